"""``pddecont completion``."""

from __future__ import annotations

import click
from click.shell_completion import CompletionItem, get_completion_class


@click.command("completion")
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
def command(shell: str) -> None:
    """Print the script that lets a shell complete commands, options and files.

    \b
      bash  pddecont completion bash >> ~/.bashrc
      zsh   pddecont completion zsh >> ~/.zshrc
      fish  pddecont completion fish > ~/.config/fish/completions/pddecont.fish
    """  # noqa: D301 - click's mark for text that is not wrapped anew
    from pddecont.cli import group

    kind = get_completion_class(shell)
    assert kind is not None
    # Without a look at the version of the shell that happens to run here.
    complete = kind(group, {}, "pddecont", "_PDDECONT_COMPLETE")
    click.echo(complete.source_template % complete.source_vars())


def complete_file(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the shipped models and runs that go on as ``incomplete`` begins.

    Where there are none, the shell looks among files.
    """
    from pddecont.data import list_shipped

    names = sorted(name for name in list_shipped() if name.startswith(incomplete))
    there = bool(incomplete) and bool(names)
    return [CompletionItem(name) for name in names] if there else [CompletionItem(incomplete, type="file")]
