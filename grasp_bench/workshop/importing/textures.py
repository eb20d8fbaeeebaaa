"""The pictures that colour a mesh: found, checked from their headers, and read within one limit together.

Colours never decide about the geometry: whatever is wrong with a picture is a note.
"""

from __future__ import annotations

import io
import warnings

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from grasp_bench.workshop.importing.folder import Folder, RefusedError

MAX_PIXELS = 8192 * 8192
"""Greatest number of pixels of all textures of an object together."""
IMAGE_FORMATS = ("PNG", "JPEG", "BMP", "TGA", "WEBP", "GIF", "TIFF")


class Textures:
    """The pictures of one object.

    Attributes:
        folder: the only folder that is read from.
        notes: what was not found, not readable or found elsewhere.
    """

    def __init__(self, folder: Folder) -> None:
        self.folder = folder
        self.notes: list[str] = []
        self._pixels = 0
        self._opened: dict[bytes, Image.Image | None] = {}
        self._pixels_of: dict[bytes, NDArray[np.uint8]] = {}

    def find(self, reference: str) -> bytes | None:
        """Return the content of a referenced file; None, with a note, where there is none to read."""
        try:
            path, note = self.folder.find(reference)
            content = self.folder.read(str(path), absolute=True)
        except FileNotFoundError as error:
            several = str(error) if "may be any of" in str(error) else f"{reference} is missing"
            self.say(f"{several}: imported without it")
            return None
        except RefusedError as error:
            self.say(f"{error}: imported without it")
            return None
        if note:
            self.say(note)
        return content

    def image(self, content: bytes, name: str) -> Image.Image | None:
        """Open a picture; None, with a note, for what is none, or too large beside those opened before."""
        if content not in self._opened:
            try:
                self._opened[content] = self._open(content, name)
            except RefusedError as error:
                self.say(f"{error}: imported without it")
                self._opened[content] = None
        return self._opened[content]

    def pixels(self, content: bytes, name: str) -> NDArray[np.uint8] | None:
        """Return a picture as (H, W, 3), one array for the same content: many materials may share it."""
        picture = self.image(content, name)
        if picture is None:
            return None
        if content not in self._pixels_of:
            self._pixels_of[content] = np.asarray(picture)
        return self._pixels_of[content]

    def token(self, content: bytes, name: str) -> bytes | None:
        """Return a picture of one pixel that stands for another, for libraries that would copy that one."""
        if self.pixels(content, name) is None:
            return None
        number = list(self._pixels_of).index(content)
        plain = io.BytesIO()
        Image.new("RGB", (1, 1), (number >> 16, number >> 8 & 255, number & 255)).save(plain, "BMP")
        return plain.getvalue()

    def behind(self, token: Image.Image) -> NDArray[np.uint8]:
        """Return the picture (H, W, 3) that a :meth:`token` stands for."""
        red, green, blue = np.asarray(token.convert("RGB"))[0, 0].tolist()
        return list(self._pixels_of.values())[red << 16 | green << 8 | blue]

    def _open(self, content: bytes, name: str) -> Image.Image:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # counted below
                picture = Image.open(io.BytesIO(content), formats=IMAGE_FORMATS)
        except Image.DecompressionBombError as error:
            raise RefusedError(
                f"the texture {name} is too large; at most {MAX_PIXELS} pixels are read"
            ) from error
        except Exception as error:
            raise RefusedError(
                f"the texture {name} is not a readable picture ({', '.join(IMAGE_FORMATS)})"
            ) from error
        width, height = picture.size
        if self._pixels + width * height > MAX_PIXELS:
            before = f" after {self._pixels} of others" if self._pixels else ""
            raise RefusedError(
                f"the texture {name} has {width} × {height} pixels{before}; at most {MAX_PIXELS} are read"
            )
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                whole = picture.convert("RGB")  # decoded now: a torn one shows here
        except Exception as error:
            raise RefusedError(f"the texture {name} is not a whole picture") from error
        self._pixels += width * height
        return whole

    def say(self, note: str) -> None:
        """Take a note, once."""
        if note not in self.notes:
            self.notes.append(note)
