"""Parts of the files of a run: classes that both write and read them."""

from __future__ import annotations

import json
import warnings
from typing import Annotated, Any, ClassVar, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from grasp_bench.system.texts import legible_all, shown

LARGEST = 2**63 - 1
"""No whole number in a results file is larger."""
Count = Annotated[int, Field(strict=True, ge=0, le=LARGEST, description="a whole number from 0")]
Number = Annotated[float, Field(strict=True, allow_inf_nan=False, description="a number")]
Text = Annotated[str, Field(strict=True, description="text")]


class Stored(BaseModel):
    """Content of a results file: frozen; unknown keys are kept, as a later version may have written them.

    A field's description says what it must be, for errors.
    """

    model_config = ConfigDict(
        extra="allow", frozen=True, arbitrary_types_allowed=True, ser_json_inf_nan="constants"
    )
    leading: ClassVar[tuple[str, ...]] = ()
    """Keys that come first, in files and among errors; the others follow in the order of their fields."""

    @model_validator(mode="before")
    @classmethod
    def _legible(cls, content: Any) -> Any:
        return legible_all(content)

    @classmethod
    def read(cls, content: Any) -> Self:
        """Return the content of a file, checked; ValueError says what is wrong first."""
        if not isinstance(content, dict):
            raise ValueError(f"{shown(content)} is not a record")
        try:
            return cls.model_validate(content)
        except RecursionError as error:
            raise ValueError("nested too deeply") from error
        except ValidationError as error:
            first = min(error.errors(), key=lambda e: cls._place(*e["loc"][:1]))
            if not first["loc"]:
                raise ValueError(first["msg"].removeprefix("Value error, ")) from error
            key = str(first["loc"][0])
            if key not in content:
                raise ValueError(f"{key!r} is missing") from error
            field = cls.model_fields.get(key)  # None for one of those that only this content has
            words = field.description if field and field.description else "a number"
            raise ValueError(f"{key!r} must be {words}, not {shown(content[key])}") from error

    @classmethod
    def _place(cls, key: int | str = "") -> int:
        return cls.leading.index(str(key)) if key in cls.leading else len(cls.leading)

    def to_json(self) -> dict[str, Any]:
        """Return plain data, as it is written."""
        return self.model_dump(mode="json")

    def __getitem__(self, key: str) -> Any:
        """Return the content of a key as it is written; deprecated, use the attribute."""
        warnings.warn(f"[{key!r}] is deprecated; use .{key}", DeprecationWarning, stacklevel=2)
        return self.to_json()[key]

    def line(self) -> str:
        """Return the content as one line of JSON; the same content is always the same line."""
        return json.dumps(self.to_json(), ensure_ascii=False, separators=(", ", ": "), allow_nan=False)


def strict_json(text: str) -> Any:
    """Return the content of JSON text; ValueError for what JSON lacks, and for a key that comes twice."""
    try:
        return json.loads(text, parse_constant=_no_constant, object_pairs_hook=_unique)
    except RecursionError as error:
        raise ValueError("nested too deeply") from error


def _no_constant(name: str) -> float:
    raise ValueError(f"{name} is no number")


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    content = dict(pairs)
    if len(content) != len(pairs):
        keys = [k for k, _ in pairs]
        raise ValueError(f"the key {shown(next(k for k in keys if keys.count(k) > 1))} comes twice")
    return content
