"""Campaigns: many flights of one scenario whose doors, winds and sensors are drawn by chance, and batches of one task.

A campaign needs the extra `campaign`, a batch only `sim`.
"""

from doorman.campaign.batch import BatchFlight, simulate_batch
from doorman.campaign.judgement import Judgement, judge
from doorman.campaign.specification import Campaign

__all__ = ["BatchFlight", "Campaign", "Judgement", "judge", "simulate_batch"]
