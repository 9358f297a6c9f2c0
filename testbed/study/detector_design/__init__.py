"""The study `detector-design`: the change detectors of Razavi's thesis, as printed and as they should be."""
