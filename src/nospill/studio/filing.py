"""The tab Files: opening, saving and handing out, with one line about how it went."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nospill.errors import NospillError
from nospill.plans.plan import Plan
from nospill.scene.scene import Scene
from nospill.studio import documents
from nospill.studio.checks import Check
from nospill.studio.controls import Controls
from nospill.studio.pages import file_note

if TYPE_CHECKING:
    import viser


class FileDesk:
    """What the buttons of the tab do; scenario and plan are asked for when one is pressed."""

    def __init__(
        self,
        client: viser.ClientHandle,
        controls: Controls,
        folder: Path,
        *,
        take: Callable[[dict[str, Any]], None],
        checked: Callable[[], Check],
        plan: Callable[[], Plan | None],
    ) -> None:
        """Let the controls do what they say.

        Args:
            client: the browser tab.
            controls: of it.
            folder: where scenario files are opened and saved.
            take: called with the table of a scenario that was opened.
            checked: the scenario on the screen.
            plan: the last one.
        """
        self._client, self._controls, self._folder = client, controls, folder
        self._take, self._checked, self._plan = take, checked, plan
        for handle, action in (
            (controls.open_button, self._open),
            (controls.save_button, self._save),
            (controls.download_button, self._download),
            (controls.export_button, self._export),
        ):
            handle.on_click(self._guarded(action))
        controls.upload.on_upload(self._uploaded)

    def say(self, text: str, *, wrong: bool = False) -> None:
        """Write a line above the buttons."""
        self._controls.file_message.content = file_note(text, wrong=wrong)

    def _guarded(self, action: Callable[[], None]) -> Callable[[Any], None]:
        """Say why an action came to nothing."""

        def run(_event: Any) -> None:
            try:
                action()
            except NospillError as error:
                self.say(" ".join(str(error).split()), wrong=True)

        return run

    def _open(self) -> None:
        name = self._controls.choice.value
        self._opened(documents.open_scenario(name, self._folder), name)

    def _uploaded(self, event: Any) -> None:
        file = event.target.value
        self._guarded(lambda: self._opened(documents.read_upload(file.name, file.content), file.name))(event)

    def _opened(self, table: dict[str, Any], name: str) -> None:
        self._take(table)
        self.say(f"{name} opened; Undo brings the old one back")

    def _scene_to_write(self) -> Scene | None:
        found = self._checked()
        if found.scene is None:
            self.say(f"Not written: {found.faults[0].sentence}", wrong=True)
        return found.scene

    def _save(self) -> None:
        scene = self._scene_to_write()
        if scene is not None:
            path = documents.save_scenario(scene, self._folder)
            self._controls.show_choices(documents.scenario_choices(self._folder))
            self.say(f"Written to {path}")

    def _download(self) -> None:
        scene = self._scene_to_write()
        if scene is not None:
            self._send(documents.scenario_download(scene))

    def _export(self) -> None:
        plan = self._plan()
        if plan is not None:
            self.say("Writing and judging ...")
            self._send(documents.export_plan(plan, self._controls.format.value))

    def _send(self, download: documents.Download) -> None:
        self._client.send_file_download(download.name, download.content, save_immediately=True)
        self.say(download.message)
