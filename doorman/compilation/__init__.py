"""Ahead-of-flight compilation: the decorator of every numba kernel, and its cache on disk."""

from doorman.compilation.cached_kernels import (
    PRINTED,
    CacheContent,
    KernelCounts,
    belongs_to,
    cache_content,
    cache_directory,
    check_compiler,
    entry,
    kept,
    kernel,
    kernel_counts,
    known_kernels,
)

__all__ = [
    "PRINTED",
    "CacheContent",
    "KernelCounts",
    "belongs_to",
    "cache_content",
    "cache_directory",
    "check_compiler",
    "entry",
    "kept",
    "kernel",
    "kernel_counts",
    "known_kernels",
]
