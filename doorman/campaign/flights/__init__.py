"""How the flights of a campaign are flown: orders, processes that carry them out, and what software they ran on."""
