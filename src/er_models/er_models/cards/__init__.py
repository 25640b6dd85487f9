"""Parts of the documentation card of an effect: equation, picture, page."""
