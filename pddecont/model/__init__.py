"""From text to a model: YAML document, checked expressions, symbolic system, numeric functions."""
