"""Trained from some placements of tool and object: does an agent get on from others?"""
