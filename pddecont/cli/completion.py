"""``pddecont completion``."""

from __future__ import annotations

import click
from click.shell_completion import get_completion_class


@click.command("completion")
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
def command(shell: str) -> None:
    """Print the script that lets a shell complete commands, options and files.

    What is in a file is completed too, where the file stands before: steps, labels, parameters and what axes show.

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
