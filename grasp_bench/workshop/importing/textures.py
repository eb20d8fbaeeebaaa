"""The pictures that colour a mesh: found, checked from their headers, and read within one limit together.

Colours never decide about the geometry: whatever is wrong with a picture is a note.
"""

from __future__ import annotations

import io
import warnings

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
