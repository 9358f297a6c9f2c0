"""A drive's recording: the log file that is also what one looks at."""

from testbed.recording.writer import RecordingError, RecordingWriter

__all__ = ["RecordingError", "RecordingWriter"]
