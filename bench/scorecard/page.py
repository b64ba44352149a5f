def write(score, root):
    pass
