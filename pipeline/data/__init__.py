"""Datasets: their schema, lineage and identity; recording, selecting, merging; the query ledger.

A dataset is a LeRobot v3.0 directory. Recording goes through LeRobot (10 s to import, so only when
it is called); all else needs pyarrow and OpenCV only.
"""
