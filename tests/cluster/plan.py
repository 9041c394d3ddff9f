#!/usr/bin/env python3
"""Computes how many jobs and how many rows per band are best on a cluster.

    plan.py --sfera target/release/sfera          measures this machine, then plans
    plan.py --start 0.002 --read 0.2e9 ...        plans with the given figures

The time of a band, on a core:

    launch + start + scene bytes / read + prepare + rows * width * pixel

The first two are the scheduler's and the process's. Scenes are read from, and
pixels written to, one file system, whose bandwidth all jobs share evenly; a
pixel is 3 bytes. All bands are taken to be equally hard.
"""

import argparse
import heapq
import json
import math
import random
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

BYTES_PER_PIXEL = 3
OVERHEAD = 0.05
JOBS = (1, 10, 30, 100, 300, 1000)


class Figures:
    """Seconds, and bytes per second, of one core."""

    def __init__(self, launch, start, read, prepare, pixel):
        self.launch, self.start, self.read = launch, start, read
        self.prepare, self.pixel = prepare, pixel

    def __str__(self):
        return (f"launch {self.launch * 1e3:.0f} ms, start {self.start * 1e3:.1f} ms, "
                f"read {self.read / 1e6:.0f} MB/s, prepare {self.prepare * 1e3:.1f} ms, "
                f"pixel {self.pixel * 1e9:.2f} ns")


class Job:
    """A scene and the size of its picture."""

    def __init__(self, spheres, scene_bytes, width, height):
        self.spheres, self.scene_bytes = spheres, scene_bytes
        self.width, self.height = width, height


# --- Measuring.

def measure(sfera, spheres, launch):
    """The figures of this machine, one thread, medians; and the bytes of the scene."""
    # As large as fits most disks: the larger a picture, the fewer of its pixels are edges.
    side, few, many = 20_000, 16, 1_616
    with tempfile.TemporaryDirectory() as folder:
        scene, image = Path(folder, "scene.txt"), Path(folder, "image.ppm")
        scene.write_text(cloud(spheres))
        scene_bytes = scene.stat().st_size
        # Two bands differ only in the number of pixels.
        small, large = (median_run(sfera, scene, image, side, rows) for rows in (few, many))
        pixel = (large["render"] - small["render"]) / (side * (many - few))
        prepare = small["prepare"] + max(0, small["render"] - pixel * side * few)
        figures = Figures(launch, small["wall"] - small["total"], scene_bytes / small["read"],
                          prepare, pixel)
        return figures, scene_bytes


def median_run(sfera, scene, image, side, rows):
    middle = (side - rows) // 2
    command = [sfera, scene, image, str(side), str(side), "--rows", f"{middle}..{middle + rows}",
               "--threads", "1", "--stats=json"]
    runs = []
    for _ in range(8):
        began = time.perf_counter()
        process = subprocess.run(command, stderr=subprocess.PIPE, text=True, timeout=300)
        wall = time.perf_counter() - began
        if process.returncode != 0:
            raise SystemExit(process.stderr)
        phases = json.loads(process.stderr.splitlines()[-1])["milliseconds"]
        runs.append({"wall": wall, **{phase: ms / 1e3 for phase, ms in phases.items()}})
    # The first run makes the file and reads everything else into memory.
    return {phase: statistics.median(run[phase] for run in runs[1:]) for phase in runs[0]}


def cloud(spheres):
    """Spheres spread over the view, their radii shrinking as they grow in number."""
    chance = random.Random(7)
    lines = [f"VP 1 1 1\nBG 255 255 255\nOBJ_N {spheres}"]
    radius = 12 * spheres ** (-1 / 3)
    for _ in range(spheres):
        z = chance.uniform(10, 30)
        x, y = (chance.uniform(-0.5, 0.5) * z for _ in range(2))
        red, green, blue = (chance.randrange(256) for _ in range(3))
        lines.append(f"S {x:.5f} {y:.5f} {z:.5f} {radius:.5f} {red} {green} {blue}")
    return "\n".join(lines) + "\n"


# --- Planning.

def fixed_seconds(figures, job):
    """The time of each band before its first pixel."""
    return figures.launch + figures.start + job.scene_bytes / figures.read + figures.prepare


def rows_for_overhead(figures, job):
    """The fewest rows of a band whose fixed cost is at most OVERHEAD of its time."""
    row = job.width * figures.pixel
    return math.ceil(fixed_seconds(figures, job) * (1 / OVERHEAD - 1) / row)


class Transfers:
    """Transfers of one kind that are under way: all run at one rate, at most `cap`."""

    def __init__(self, cap):
        self.cap, self.rate, self.moved, self.ends = cap, 0.0, 0.0, []

    def add(self, size, slot):
        heapq.heappush(self.ends, (self.moved + size, slot))

    def next_end(self):
        return (self.ends[0][0] - self.moved) / self.rate if self.ends else math.inf


def share(bandwidth, kinds):
    """Gives each transfer its even share, and what one can't use to the others."""
    left, waiting = bandwidth, sum(len(kind.ends) for kind in kinds)
    for kind in sorted(kinds, key=lambda kind: kind.cap):
        if kind.ends:
            kind.rate = min(kind.cap, left / waiting)
            left -= kind.rate * len(kind.ends)
            waiting -= len(kind.ends)


def simulate(figures, job, jobs, bands, bandwidth, client):
    """Seconds until `jobs` slots have drawn `bands` bands."""
    pixels = [job.width * (job.height * (band + 1) // bands - job.height * band // bands)
              for band in range(bands)]
    reads = Transfers(min(figures.read, client))
    writes = Transfers(min(BYTES_PER_PIXEL / figures.pixel, client))
    now, timers, of_slot = 0.0, [], {}

    def begin(slot):
        if pixels:
            of_slot[slot] = pixels.pop()
            heapq.heappush(timers, (now + figures.launch + figures.start, "read", slot))

    for slot in range(min(jobs, bands)):
        begin(slot)
    while timers or reads.ends or writes.ends:
        share(bandwidth, (reads, writes))
        timer = timers[0][0] - now if timers else math.inf
        step = max(0.0, min(timer, reads.next_end(), writes.next_end()))
        ends = [kind.ends[0][0] if kind.ends and kind.next_end() <= step else None
                for kind in (reads, writes)]
        now += step
        for kind in (reads, writes):
            kind.moved += step * kind.rate
        if timer <= step:
            _, phase, slot = heapq.heappop(timers)
            if phase == "read":
                reads.add(job.scene_bytes, slot)
            else:
                writes.add(of_slot[slot] * BYTES_PER_PIXEL, slot)
        if ends[0] is not None:
            _, slot = heapq.heappop(reads.ends)
            heapq.heappush(timers, (now + figures.prepare, "draw", slot))
        if ends[1] is not None:
            _, slot = heapq.heappop(writes.ends)
            begin(slot)
    return now


def limit(figures, job, jobs, bands, bandwidth, client, seconds):
    """The bottleneck: the cost whose removal helps most."""
    no_launch = Figures(0, 0, figures.read, figures.prepare, figures.pixel)
    no_scene = Figures(figures.launch, figures.start, figures.read, 0, figures.pixel)
    ways = {
        "pixels": simulate(Figures(figures.launch, figures.start, figures.read, figures.prepare,
                                   figures.pixel / 10), job, jobs, bands, bandwidth, client),
        "launch": simulate(no_launch, job, jobs, bands, bandwidth, client),
        "scene": simulate(no_scene, Job(0, 1, job.width, job.height), jobs, bands, bandwidth, client),
        "file system": simulate(figures, job, jobs, bands, bandwidth * 1e3, client),
        "link of a job": simulate(figures, job, jobs, bands, bandwidth, client * 1e3),
    }
    best = min(ways, key=ways.get)
    return best if ways[best] < 0.98 * seconds else "-"


def print_plan(figures, job, bandwidth, client):
    fixed, least = fixed_seconds(figures, job), rows_for_overhead(figures, job)
    row = job.width * figures.pixel
    print(f"\n{job.width:,} x {job.height:,}, {job.spheres:,} spheres "
          f"({job.width * job.height * BYTES_PER_PIXEL / 1e9:,.0f} GB from {job.scene_bytes / 1e6:,.1f} MB); "
          f"file system {bandwidth / 1e9:g} GB/s for all, {client / 1e9:g} GB/s for one")
    print(f"{figures}")
    print(f"a band: {fixed:.2f} s + {row * 1e6:,.0f} µs a row; overhead is under {OVERHEAD:.0%} "
          f"from {least:,} rows ({row * least:.1f} s), so in up to {job.height // least:,} bands")
    print("\n| jobs | rows a band | seconds | times one job | overhead | limited by |")
    print("| --- | --- | --- | --- | --- | --- |")
    one = simulate(figures, job, 1, 1, bandwidth, client)
    for jobs in JOBS:
        if jobs > job.height:
            break
        # One band for each job: if bands take equally long, more bands only cost more.
        seconds = simulate(figures, job, jobs, jobs, bandwidth, client)
        rows = job.height / jobs
        overhead = fixed / (fixed + rows * row)
        print(f"| {jobs:,} | {rows:,.0f} | {seconds:.1f} | {one / seconds:.1f} | {overhead:.1%} | "
              f"{limit(figures, job, jobs, jobs, bandwidth, client, seconds)} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0],
                                     formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    parser.add_argument("--sfera", type=Path, help="program to measure; without it, the figures below hold")
    parser.add_argument("--launch", type=float, default=2.2, help="seconds a scheduler takes to start a band")
    parser.add_argument("--start", type=float, default=0.002, help="seconds of a process beside its work")
    parser.add_argument("--read", type=float, default=100e6, help="bytes of a scene read in a second")
    parser.add_argument("--prepare", type=float, default=0.1, help="seconds from the scene to the first pixel")
    parser.add_argument("--pixel", type=float, default=2e-9, help="seconds to draw a pixel")
    parser.add_argument("--scene-bytes", type=float, help="bytes of the scene; 50 a sphere if not given")
    parser.add_argument("--spheres", type=int, default=1_000_000)
    parser.add_argument("--width", type=int, default=200_000)
    parser.add_argument("--height", type=int, default=200_000)
    parser.add_argument("--bandwidth", type=float, default=10e9, help="bytes a second of the shared file system")
    parser.add_argument("--client", type=float, default=1.2e9, help="bytes a second of one job's link to it")
    given = parser.parse_args()

    scene_bytes = given.scene_bytes or 50 * given.spheres
    if given.sfera:
        figures, scene_bytes = measure(given.sfera, given.spheres, given.launch)
    else:
        figures = Figures(given.launch, given.start, given.read, given.prepare, given.pixel)
    job = Job(given.spheres, scene_bytes, given.width, given.height)
    print_plan(figures, job, given.bandwidth, given.client)


if __name__ == "__main__":
    main()
