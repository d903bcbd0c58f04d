"""The MCAP file: messages as CDR, chunks and records, written and read."""
