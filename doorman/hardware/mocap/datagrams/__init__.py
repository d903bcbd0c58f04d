"""Datagrams: packets of the object stream into new measurements, with what is wrong on the way."""
