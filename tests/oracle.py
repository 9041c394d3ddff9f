"""The sphere that each pixel of a scene shows, computed independently of sfera.

    python3 oracle.py SCENE WIDTH HEIGHT [SCENE WIDTH HEIGHT ...]

prints for each scene one line for each row: the number of the sphere that each
pixel shows, -1 for the background.

It shares nothing with src/reference.rs. It reads the text itself and rounds it to
floats in rational arithmetic; it solves for the distance t along the ray,
A t^2 - 2 B t + c = 0, not for its inverse; and it orders two roots by enclosing them
more and more tightly, where the reference squares. If the enclosures still overlap
when they are narrower than the least distance of two different roots, the roots are
equal.
"""

import struct
import sys
from fractions import Fraction
from math import isqrt


def float_bits(bits):
    return Fraction(struct.unpack("<f", struct.pack("<I", bits))[0])


def nearest_float(text):
    """The float nearest to a decimal number, ties to even, by exact comparison."""
    exact = Fraction(text)
    magnitude = abs(exact)
    low, high = 0, 0x7F7FFFFF  # the bits of positive floats are ordered as they are
    if magnitude > float_bits(high):
        rounded = float_bits(high)
    else:
        while low + 1 < high:
            middle = (low + high) // 2
            if float_bits(middle) <= magnitude:
                low = middle
            else:
                high = middle
        below, above = magnitude - float_bits(low), float_bits(high) - magnitude
        up = above < below or (above == below and low % 2 == 1)
        rounded = float_bits(high if up else low)
    return -rounded if exact < 0 else rounded


def read(path):
    with open(path) as file:
        words = [word for line in file for word in line.split("#")[0].split()]
    words = iter(words)
    assert next(words) == "VP"
    viewport = [nearest_float(next(words)) for _ in range(3)]
    assert next(words) == "BG"
    for _ in range(3):
        next(words)
    assert next(words) == "OBJ_N"
    spheres = []
    for _ in range(int(next(words))):
        assert next(words) == "S"
        spheres.append([nearest_float(next(words)) for _ in range(4)])
        for _ in range(3):
            next(words)
    return viewport, spheres


def integers(numbers):
    """Dyadic rationals, all times the largest of their denominators."""
    factor = max((number.denominator for number in numbers), default=1)
    return [int(number * factor) for number in numbers]


class Root:
    """t A = b + sign sqrt(d), b and d integers, d >= 0."""

    def __init__(self, b, sign, d):
        self.b, self.sign, self.d = b, sign, d

    def enclosed(self, bits):
        """Integers low, high with low <= 2^bits t A <= high."""
        root = isqrt(self.d << 2 * bits)
        exact = root * root == self.d << 2 * bits
        low, high = root, root if exact else root + 1
        if self.sign < 0:
            low, high = -high, -low
        return (self.b << bits) + low, (self.b << bits) + high


def nearer(one, other):
    """Whether root `one` is strictly nearer than `other`."""
    # Their difference is an algebraic integer. If it isn't 0, the product of its
    # conjugates is an integer other than 0; there are at most four of them, all
    # smaller than 2^size, so none is smaller than 2^-(3 size).
    size = max(abs(one.b), abs(other.b), one.d, other.d).bit_length() + 3
    bits = 8
    while True:
        low, high = one.enclosed(bits)
        other_low, other_high = other.enclosed(bits)
        if high < other_low:
            return True
        if other_high < low:
            return False
        if bits > 3 * size + 4:
            return False
        bits *= 2


def hit(sphere, ray):
    x, y, z, r = sphere
    vx, vy, vz = ray
    a = vx * vx + vy * vy + vz * vz
    b = x * vx + y * vy + z * vz
    outside = x * x + y * y + z * z - r * r
    d = b * b - a * outside
    if outside < 0:
        return Root(b, +1, d)
    if b <= 0 or d < 0:
        return None
    return Root(b, +1, d) if outside == 0 else Root(b, -1, d)


def seen(spheres, ray):
    best, nearest = -1, None
    for index, sphere in enumerate(spheres):
        root = hit(sphere, ray)
        if root is not None and (nearest is None or nearer(root, nearest)):
            best, nearest = index, root
    return best


def picture(path, width, height):
    (vx, vy, vz), spheres = read(path)
    half = Fraction(1, 2)
    lengths = integers([length for sphere in spheres for length in sphere])
    spheres = [lengths[at : at + 4] for at in range(0, len(lengths), 4)]
    for row in range(height):
        y = vy * (half - Fraction(row, height - 1)) if height > 1 else Fraction(0)
        line = []
        for column in range(width):
            x = vx * (Fraction(column, width - 1) - half) if width > 1 else Fraction(0)
            ray = [x, y, vz]
            factor = 1
            for component in ray:
                factor *= component.denominator
            line.append(seen(spheres, [int(component * factor) for component in ray]))
        yield line


def main(arguments):
    for at in range(0, len(arguments), 3):
        path, width, height = arguments[at : at + 3]
        for line in picture(path, int(width), int(height)):
            print(*line)


main(sys.argv[1:])
