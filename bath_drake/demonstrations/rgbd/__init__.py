"""Recordings of a depth camera: a folder of colour and depth images."""
