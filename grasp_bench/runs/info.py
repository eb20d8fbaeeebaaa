"""The content of ``run.json``, written and read by the same class."""

from __future__ import annotations

from enum import Enum, auto
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, SerializerFunctionWrapHandler, model_serializer

from grasp_bench.errors import ScenarioError
from grasp_bench.runs.differences import differences
from grasp_bench.runs.schema import Count, Stored, Text
from grasp_bench.scenario.reading import parse_scenario
from grasp_bench.scenario.sections import VERSION, Scenario

RUN = "run.json"


class Group(Enum):
    """Meaning of a key of ``run.json``; every key names its groups where it is declared."""

    TRIALS = auto()
    """The trials of a run."""
    MAKING = auto()
    """The predictor, and the means by which trials were carried out."""
    INSTALLED = auto()
    """Facts that a repetition takes from its installation, not from the record."""
    SHARE = auto()
    """The part of the trials that a folder is to hold."""
    ORIGIN = auto()
    """The place where a run was made: may differ, but explains why numbers do."""


SAME_RUN = (Group.TRIALS, Group.MAKING)
"""Keys that must agree for results to belong together."""
RESUMABLE = (*SAME_RUN, Group.SHARE)
"""Keys that must agree before a run may be resumed."""


_WHERE_KNOWN = ("shard", "robot", "environment", "apart", "drawn")
"""Keys that are written only where there is something to say."""


def _named(scenario: dict[str, Any]) -> dict[str, Any]:
    if not isinstance(scenario.get("name"), str):
        raise ValueError("the scenario has no name")
    return scenario


Table = Annotated[dict[str, Any], Field(description="an object")]


class RunInfo(Stored):
    """The content of ``run.json``; docs/results-format.md says what each key means."""

    format: Annotated[Literal[1], Field(description="1, the format that this version reads")] = 1
    command: tuple[Text, ...] = ()
    predictor: Annotated[Text, Group.MAKING]
    implementation: Annotated[dict[str, Any] | None, Group.MAKING, Group.INSTALLED] = None
    scenario: Annotated[
        dict[str, Any], AfterValidator(_named), Group.TRIALS, Field(description="a scenario with a name")
    ]
    seed: Annotated[Count, Group.TRIALS]
    trials: Annotated[Count, Group.TRIALS]
    shard: Annotated[str | None, Group.SHARE] = None
    objects: Annotated[Table, Group.TRIALS, Group.INSTALLED]
    weights: Annotated[Any, Group.MAKING, Group.INSTALLED] = None
    robot: Annotated[dict[str, Any] | None, Group.TRIALS, Group.INSTALLED] = None
    versions: Annotated[Table, Group.MAKING, Group.INSTALLED]
    renderer: Annotated[Text, Group.MAKING]
    python: Annotated[Any, Group.ORIGIN] = None
    platform: Annotated[Any, Group.ORIGIN] = None
    cpu: Annotated[Any, Group.ORIGIN] = None
    git: Annotated[Any, Group.ORIGIN] = None
    environment: Annotated[
        dict[str, Text] | None, Group.ORIGIN, Field(description="an object of texts or null")
    ] = None
    apart: Annotated[bool | None, Group.ORIGIN, Field(strict=True, description="true, false or null")] = None
    drawn: Annotated[bool | None, Group.ORIGIN, Field(strict=True, description="true, false or null")] = None

    def planned(self, done: int) -> int:
        """Return how many trials the run is to have; of a race's, which may end at any, those ``done``."""
        return done if self.drawn else self.trials

    @classmethod
    def keys(cls, *groups: Group) -> list[str]:
        """Return the names of all keys of some groups, in their order in the file."""
        wanted = set(groups)
        return [name for name, field in cls.model_fields.items() if wanted & set(field.metadata)]

    def differences(
        self, other: RunInfo, *groups: Group, places: tuple[str, str] = ("there", "here")
    ) -> dict[str, str]:
        """Return what differs between two runs in the keys of ``groups``, in words, by key.

        ``places`` says where the first and the second were found.
        """
        return differences(self.to_json(), other.to_json(), self.keys(*groups), places)

    @property
    def scenario_name(self) -> str:
        """Name of the scenario."""
        return self.scenario["name"]

    @property
    def definition(self) -> int:
        """Version of the definition of its trials."""
        version = self.scenario.get("version", 1)
        return version if isinstance(version, int) else 1

    @property
    def scenario_label(self) -> str:
        """The scenario's name, and the version of the definition where it is not today's."""
        return f"{self.scenario_name} (definition {self.definition})" if self.outdated else self.scenario_name

    @property
    def outdated(self) -> bool:
        """Its trials are of an earlier version of the definition than those of today."""
        return self.definition < VERSION

    @property
    def cluttered(self) -> bool:
        """Whether the trials are episodes of many objects."""
        return bool(self.scenario.get("clutter"))

    @property
    def tried(self) -> list[str]:
        """Objects that the trials try in turn.

        Episodes of clutter may meet any of the run's objects; who leads them, and in which order, the
        scenario says.
        """
        chosen = self.scenario.get("objects") if self.cluttered else None
        names = chosen.get("names") if isinstance(chosen, dict) else None
        return list(names) if names and isinstance(names, dict) else list(self.objects)

    def parsed(self, origin: str = RUN) -> Scenario:
        """Return the scenario, or raise ScenarioError naming ``origin`` where this version cannot read it."""
        return parse_scenario(self.scenario, origin)

    def comparable(self) -> RunInfo:
        """Return the same with all values of the scenario, also those newer than the run, but no words."""
        try:
            scenario = self.parsed().model_dump(mode="json")
        except ScenarioError:  # of another version of grasp-bench
            scenario = self.scenario
        return self.model_copy(update={"scenario": scenario | {"name": "", "description": ""}})

    @model_serializer(mode="wrap")
    def _without_no_shard(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return {k: v for k, v in handler(self).items() if k not in _WHERE_KNOWN or v is not None}
