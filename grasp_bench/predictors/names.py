"""What a predictor's name means. Names are taken apart here only."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any, ClassVar

from grasp_bench.errors import AssetError, PredictorError, UnknownNameError
from grasp_bench.networks.registry import NETWORKS, all_weights
from grasp_bench.networks.store import WeightsFile
from grasp_bench.predictors.protocol import Predictor
from grasp_bench.predictors.shipped import SHIPPED, TTA, Shipped, averaged
from grasp_bench.predictors.sources import distribution, make, module_of, sources
from grasp_bench.system.integrity import sha256

GROUP = "grasp_bench.predictors"
"""Group of entry points in which packages offer predictors."""
EXAMPLES = ("my_module:MyPredictor", "http://127.0.0.1:PORT", "cmd: COMMAND --port {port}")
"""How the other ways in are spelt, for messages."""
WEIGHTS = ".safetensors"
"""End of the names of files of weights."""
AT = "@"
"""Between a network and the file of its weights."""
_COMMAND = "cmd:"
_ADDRESSES = ("http://", "https://")


@dataclass(frozen=True)
class PythonPath:
    """``module:Class``, looked for on Python's path and in the current folder."""

    name: str
    kind: ClassVar[str] = "own"
    apart: ClassVar[bool] = False
    weights: ClassVar[None] = None

    @property
    def path(self) -> str:
        """``module:Class``, with its arguments if there are any."""
        return self.name

    @property
    def package(self) -> str | None:
        """Name and version of the package that it was installed with; None for a file outside any package."""
        return distribution(module_of(self.path))

    def load(self) -> Predictor:
        """Make the predictor.

        Raises:
            PredictorError: for a module that cannot be imported, or what makes no predictor.
        """
        return make(self.path, self.name)

    def facts(self, predictor: object) -> dict[str, Any]:
        """Return what identifies it: its source files, and the package they came with, if any."""
        module = module_of(self.path)
        found: dict[str, Any] = {"files": sources(module) | sources(type(predictor).__module__)}
        return found | ({"distribution": self.package} if self.package else {})


@dataclass(frozen=True)
class Installed(PythonPath):
    """A name under which an installed package offers a predictor."""

    point: EntryPoint
    kind: ClassVar[str] = "package"

    @property
    def path(self) -> str:
        """``module:Class``."""
        return self.point.value

    @property
    def package(self) -> str | None:
        """Name and version of the package, where it says them."""
        return f"{self.point.dist.name} {self.point.dist.version}" if self.point.dist else None


@dataclass(frozen=True)
class Server:
    """The address of a server that runs already."""

    name: str
    kind: ClassVar[str] = "server"
    apart: ClassVar[bool] = True
    weights: ClassVar[None] = None

    def load(self) -> Predictor:
        """Make the server's client; PredictorError for an address that is not valid."""
        from grasp_bench.predictors.remote import RemotePredictor  # its HTTP library brings Rich

        return RemotePredictor(self.name)

    def facts(self, predictor: object) -> dict[str, Any]:
        """Return nothing: only the server can say what identifies it."""
        return {}


@dataclass(frozen=True)
class Command:
    """A command that starts a server."""

    name: str
    kind: ClassVar[str] = "command"
    apart: ClassVar[bool] = True
    weights: ClassVar[None] = None

    @property
    def command(self) -> str:
        """What is run."""
        return self.name.removeprefix(_COMMAND)

    def load(self) -> Predictor:
        """Start the server; PredictorError where that fails."""
        from grasp_bench.predictors.command import CommandPredictor

        return CommandPredictor(self.command)

    def facts(self, predictor: object) -> dict[str, Any]:
        """Return what identifies it: the files that the command names."""
        program, *words = shlex.split(self.command)
        if not Path(program).is_absolute():  # an interpreter may differ between the machines of one run
            words.insert(0, program)
        return {"files": {word: sha256(Path(word)) for word in words if Path(word).is_file()}}


@dataclass(frozen=True)
class Trained:
    """``NETWORK@FILE``: a network with weights that are not shipped; ``FILE.safetensors`` alone says
    itself of which network it is. ``NETWORK-tta@FILE`` asks it with test-time augmentation.
    """

    name: str
    kind: ClassVar[str] = "network"
    apart: ClassVar[None] = None

    @property
    def network(self) -> str:
        """The registered network; AssetError where the file does not say of which it is."""
        if named := self._parts[0]:
            return named.removesuffix(TTA)
        stored = self.weights.metadata().get("network")
        if stored not in NETWORKS:
            raise AssetError(
                f"{self.name} does not say of which network it is; name it as NETWORK{AT}{self.name}."
            )
        return stored

    @property
    def weights(self) -> WeightsFile:
        """The file of its weights."""
        return WeightsFile(self._parts[1])

    @property
    def _parts(self) -> tuple[str, Path]:
        """The network as it is named, empty where the name is that of the file alone, and the file."""
        named, _, path = self.name.partition(AT)
        return (named, Path(path)) if _names_network(named) else ("", Path(self.name))

    def load(self) -> Predictor:
        """Make the predictor; AssetError for weights that are missing, damaged or of another network."""
        from grasp_bench.predictors.network import NetworkPredictor

        named, path = self._parts
        return NetworkPredictor(self.network, path, tta=named.endswith(TTA))

    def facts(self, predictor: object) -> dict[str, Any]:
        """Return what identifies it: its weights."""
        self.weights.require()
        return {"files": {self.weights.name: self.weights.digest}}


def _names_network(name: str) -> bool:
    """Return whether a name is that of a network, asked once or with test-time augmentation."""
    return name.removesuffix(TTA) in NETWORKS


Named = Shipped | Trained | Installed | PythonPath | Server | Command


def installed() -> dict[str, list[Installed]]:
    """Return the predictors that installed packages offer, by name; nothing is imported."""
    found: dict[str, list[Installed]] = {}
    for point in entry_points(group=GROUP):
        found.setdefault(point.name, []).append(Installed(point.name, point))
    return dict(sorted(found.items()))


def parse(name: str) -> Named:
    """Return what a predictor's name means. A shipped name means that one, whatever packages are installed,
    and with ``-tta`` behind it a network's weights asked with test-time augmentation.

    Raises:
        UnknownNameError: for a name that nobody offers.
        PredictorError: for a name that several installed packages offer.
    """
    if name in SHIPPED:
        return SHIPPED[name]
    if name.endswith(TTA) and name.removesuffix(TTA) in all_weights():
        return averaged(name.removesuffix(TTA))
    if name.startswith(_ADDRESSES):
        return Server(name)
    if name.startswith(_COMMAND):
        return Command(name)
    if (AT in name and _names_network(name.partition(AT)[0])) or (name.endswith(WEIGHTS) and ":" not in name):
        return Trained(name)
    if ":" in name:
        return PythonPath(name)
    offers = installed()
    if name not in offers:
        raise UnknownNameError("predictor", name, [*SHIPPED, *offers], EXAMPLES)
    paths = sorted({offer.path for offer in offers[name]})
    if len(paths) > 1:
        raise PredictorError(
            f"Several installed packages offer a predictor {name!r}: "
            f"{' and '.join(paths)}. Name the one you mean by its module:Class."
        )
    return offers[name][0]


def with_weights(name: str, weights: Path) -> str:
    """Return the name of a network with the weights in a file; PredictorError where it names no network."""
    if not _names_network(name):
        raise PredictorError(f"--weights is for networks; {name} is none.")
    return f"{name}{AT}{weights}"


def load_predictor(name: str) -> Predictor:
    """Load a shipped predictor by name, or anyone's by one of the other ways in.

    ``module:Class`` is looked for on Python's path and in the current folder, ``./file.py:Class`` in a file.
    A class or a function is called, with the literals that ``module:Class(size=224)`` gives; what results
    must have ``predict(image) -> list[Grasp]``. ``FILE.safetensors`` is a network with weights of one's own.
    Close a predictor that has a method ``close`` after use, or use
    :func:`grasp_bench.predictors.use.in_use`.

    Raises:
        UnknownNameError: for an unknown name.
        PredictorError: for one that cannot be imported or started, or that makes no predictor.
    """
    return parse(name).load()
