"""Interior-point search with exact Hessians: memory, Newton sweep, line search and the iterations."""
