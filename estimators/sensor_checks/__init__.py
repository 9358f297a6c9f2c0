"""Does each motion sensor do what a sound one does, alone and beside its neighbours?"""
