"""Images of coloured meshes by a compiled rasteriser: what a simulated camera sees.

Drake's own renderer draws by OpenGL, which without a graphics card costs most of a
closed loop's time. This one draws the same scene, the same depth and, but for
rounding, the same colours, a pixel's centre at a time.
"""
