"""Kernels of a tick on records, which their owners in `doorman.control` keep; tests hold each against a plain twin."""
