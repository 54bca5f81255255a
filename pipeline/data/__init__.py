"""Datasets: their schema, lineage and identity; recording, selecting, merging; the query ledger.

A dataset is a LeRobot v3.0 directory. All of this needs pyarrow, Pillow and OpenCV only: LeRobot, 10 s
to import, decodes videos.
"""
