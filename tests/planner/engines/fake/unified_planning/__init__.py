"""As much of the Unified Planning Framework as up_engine.py uses, with engines that behave in known ways."""
