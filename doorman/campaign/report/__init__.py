"""Report of a campaign: figures, statistics, histograms and pages."""
