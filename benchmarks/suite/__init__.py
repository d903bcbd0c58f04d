"""doorman against its peers: what is compared, how it is measured, and what the page says."""
