"""The study `detector-design`: the change detectors of Razavi's thesis, their designs as printed and as they should be."""
