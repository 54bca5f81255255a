"""The driving world: tracks, cars, the PyBullet scene and its camera, and the Gymnasium
environment.
"""
