"""``pddecont completion``."""

from __future__ import annotations

import click


@click.command("completion")
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
def command(shell: str) -> None:
    r"""Print the script that lets a shell complete commands, options and files.

    \b
      bash  pddecont completion bash >> ~/.bashrc
      zsh   pddecont completion zsh >> ~/.zshrc
      fish  pddecont completion fish > ~/.config/fish/completions/pddecont.fish
    """
    from click.shell_completion import get_completion_class

    from pddecont.cli import group

    kind = get_completion_class(shell)
    assert kind is not None
    # Without a look at the version of the shell that happens to run here.
    complete = kind(group, {}, "pddecont", "_PDDECONT_COMPLETE")
    click.echo(complete.source_template % complete.source_vars())
