"""The one way out: tables, pictures and their descriptions into files, and the workers that make them."""
