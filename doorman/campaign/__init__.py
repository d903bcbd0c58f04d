"""Campaigns: many flights of one scenario whose doors, winds and sensors are drawn by chance; needs the extra `campaign`."""

from doorman.campaign.judgement import Judgement, judge
from doorman.campaign.specification import Campaign

__all__ = ["Campaign", "Judgement", "judge"]
