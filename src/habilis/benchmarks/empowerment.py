"""Empowerment of every kind beside what is commonly done."""

from habilis.benchmarks import Result, channels, counting, pairs


def results() -> list[Result]:
    return [*counting.results(), *channels.results(), *pairs.results()]
