"""Reading a URDF: within bounds, checked, with its shapes and meshes."""
