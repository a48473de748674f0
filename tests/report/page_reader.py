"""What the script of a page reads of its data, done once more in Python."""

import base64
import json
import re
import zlib

import numpy as np


class PageData:
    """The header of a page's data, and its arrays by their places in it."""

    def __init__(self, text):
        self.block = zlib.decompress(base64.b64decode(text, validate=True))
        self.start = 4 + int.from_bytes(self.block[:4], "little")
        self.header = json.loads(self.block[4 : self.start])

    def read(self, place):
        at, n, kind = place
        size = int(kind[1:])
        raw = np.frombuffer(self.block, np.uint8, n * size, self.start + at)
        return np.frombuffer(raw.reshape(size, n).T.tobytes(), "<" + kind)

    def step(self, name, file=0):
        return next(step for step in self.header["files"][file]["steps"] if step["name"] == name)

    def column(self, step, name):
        kind, values = next((kind, values) for found, kind, values in step["points"]["columns"] if found == name)
        return values if kind == "text" else self.read(values)


def find_data(page):
    """Return the data in the text of a page."""
    return PageData(re.search(r'id="explorer-data">([^<]*)<', page)[1])
