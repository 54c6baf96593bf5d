"""From a part to G-code: profiles of Table B.1 for two slicers, both run headless, their G-code read back."""
