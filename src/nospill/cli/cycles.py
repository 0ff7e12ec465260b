"""plan and check of a cycle: the table of its legs, one certificate, where the time goes."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from nospill.cli.notes import say_notes
from nospill.cli.progress import FILES, PLANNING_STEPS, ProgressLine
from nospill.cli.reporting import one_line, only_stderr, print_json
from nospill.cli.tables import print_lines, print_table, print_verdict, say
from nospill.errors import NoSolutionError, ScenarioError

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.export import Exporter
    from nospill.plans.cycle import CyclePlan
    from nospill.plans.plan import Plan


def plan_legs(
    scenario: str, output: Path | None, *, settings: Sequence[str], figures: bool, as_json: bool, refused: Sequence[str]
) -> int:
    """`nospill plan` of a scenario with legs; `refused` are options that were given and are about one motion."""
    if refused:
        raise ScenarioError(
            f"{scenario}: a cycle is planned without {', '.join(refused)}; use them on the folder of one of its legs"
        )
    with only_stderr() if as_json else nullcontext(), ProgressLine(PLANNING_STEPS) as progress:
        from nospill.core.files import require_replaceable
        from nospill.planning.cycles import plan_cycle
        from nospill.plans.names import is_cycle_folder
        from nospill.plots import FIRST_FIGURES, save_figures
        from nospill.scenario.cycles import load_cycle

        if output is not None:
            require_replaceable(output, replaceable=is_cycle_folder)
        cycle = load_cycle(scenario, settings=settings)
        say_notes(cycle.legs[0].scene)
        try:
            planned = plan_cycle(cycle, progress=progress.show, said=lambda name: say(f"leg {name}"))
        except (ScenarioError, NoSolutionError) as error:
            raise type(error)(f"{scenario}: {error}", error.reason) from error

        found = planned.with_second_looks()

        def draw(one: Plan, folder: Path) -> None:
            save_figures(one, folder / "figures", names=FIRST_FIGURES, pdf=False, progress=progress.drawn)

        if output is not None:
            progress.say(FILES)
            whole = functools.partial(_draw_whole, found) if figures else None
            found.save(output, extra=draw if figures else None, figures=whole)
    if as_json:
        print_json(found.summary())
    else:
        _print(found)
        print_lines(f"written to {output}" if output is not None else "nothing written; -o DIR keeps the plan")
        _print_verdict(found)
    if not found.certificate.ok:
        say(one_line(found.message))
    return 0 if found.certificate.ok else 1


def _draw_whole(found: CyclePlan, folder: Path) -> None:
    from nospill.plots.cycle import save_cycle_figure

    save_cycle_figure(found, folder / "cycle.png")


def check_legs(folder: Path, *, printed: Callable[..., None] | None) -> int:
    """`nospill check` of the folder of a cycle: every leg, dwell and seam, and the controller files of the legs.

    `printed` prints the whole certificate of a leg, where that is asked for.
    """
    from nospill.export.plan_files import compare_plan_files
    from nospill.plans.cycle import leg_folder
    from nospill.plans.cycle_folder import load_cycle_plan
    from nospill.plans.cycle_judge import judge_cycle

    judged = judge_cycle(load_cycle_plan(folder))
    changed = list(judged.certificate.changed)
    for index, (leg, one) in enumerate(zip(judged.cycle.legs, judged.legs, strict=True)):
        place = folder / leg_folder(index, leg.name)
        if printed is not None:
            print_lines(f"leg {leg.name}:")
            printed(one.certificate, one.scene, everything=True)
        compared = compare_plan_files(one.trajectory, one.scene, place)
        changed += [f"{place / name} {difference}" for name, difference in compared.items() if difference]
    judged = judged.with_changes(changed)
    _print(judged)
    for fault in changed:
        say(f"changed: {fault}.")
    if not judged.certificate.ok:
        say(one_line(judged.message))
    _print_verdict(judged)
    return 0 if judged.certificate.ok else 1


def export_legs(folder: Path, exporter: Exporter, target: Path, *, rate: float | None) -> int:
    """`nospill export` of the folder of a cycle: one file for all legs and dwells."""
    from nospill.certification.wording import finding, verdict_line
    from nospill.export.payload import payload_of
    from nospill.plans.cycle_folder import load_cycle_plan
    from nospill.plans.cycle_handover import hand_over_cycle

    plan = load_cycle_plan(folder)
    done = hand_over_cycle(plan, exporter, target, rate=rate)
    print_lines(
        f"written to {done.path}: {done.samples} samples at {done.rate:.6g} Hz ({exporter.name}), the whole cycle",
        f"played by {exporter.receiver}",
        f"read back: joints within {done.joint_deviation:.2g} rad of the plan at all times",
    )
    for leg, one, (name, certificate) in zip(plan.times, plan.legs, done.certificates, strict=True):
        print_lines(f"leg {name} from {leg.begins:.3f} s: {verdict_line(certificate)}; {payload_of(one.scene).words()}")
    caution = exporter.caution(plan.legs[0].scene, round(done.rate, 3))
    if caution is not None:
        say(f"{done.path}: {caution}.")
    for name, certificate in done.certificates:
        if not certificate.ok:
            say(f'{done.path} is not certified as {exporter.name}: leg "{name}": {finding(certificate)}.')
    good = done.ok and plan.certificate.holds_together
    print_verdict(f"{'certified' if good else 'not certified'}: {len(done.certificates)} legs in one file", good)
    return 0 if good else 1


def _print(found: CyclePlan) -> None:
    from nospill.certification.wording import describe

    lines = [
        (
            leg.name,
            f"{leg.begins:.3f} s",
            f"{leg.motion:.3f} s",
            f"{leg.dwell:.3f} s",
            f"{100 * leg.share:.0f} %",
            one.certificate.word,
            describe(one.certificate.worst),
        )
        for leg, one in zip(found.times, found.legs, strict=True)
    ]
    columns = ("leg", "begins", "motion", "dwell", "share", "verdict", "nearest to its limit")
    right = ("begins", "motion", "dwell", "share")
    print_table(columns, lines, right=right, drop=("begins", "share"))
    print()
    for line in _warnings(found):
        print_lines(f"warning, {line}")
    cycles, moves, unloaded = found.cycles_per_hour, found.moves_per_hour, found.unloaded_per_hour
    off = f", {unloaded:.0f} objects taken off an hour" if unloaded else ""
    print_lines(
        f"cycle: {found.duration:.3f} s; {cycles:.0f} cycles an hour, {moves:.0f} moves an hour{off}",
        found.losses_text,
        found.repeats_text,
    )


def _warnings(found: CyclePlan) -> list[str]:
    """A line for each kind of warning: the leg that gives it first, and the names of the others."""
    from nospill.certification.wording import full_model_note
    from nospill.plans.warnings.record import warning_lines

    kinds: dict[str, list[tuple[str, str]]] = {}
    for leg, one in zip(found.times, found.legs, strict=True):
        note = full_model_note(one.certificate)
        for line in [*([f"full model: {note}"] if note else []), *warning_lines(one.warnings)]:
            kinds.setdefault(line.partition(":")[0], []).append((leg.name, line))
    return [
        f"leg {name}: {line}" + (f" Also on leg {', '.join(other for other, _ in others)}." if others else "")
        for (name, line), *others in kinds.values()
    ]


def _print_verdict(found: CyclePlan) -> None:
    seams = f"{len(found.legs)} legs, dwells and seams"
    print_verdict(f"{found.certificate.word}: {found.duration:.3f} s, {seams}", found.certificate.ok)
