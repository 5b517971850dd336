"""From a case to a result file: setup, coupled march, records."""
