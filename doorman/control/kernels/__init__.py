"""Kernels of a tick on flat memory, which their owners in `doorman.control` keep; tests hold each against a plain twin."""
