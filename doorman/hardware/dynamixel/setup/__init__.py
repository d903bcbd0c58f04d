"""From a servo in any state to one that is ready, and back."""
