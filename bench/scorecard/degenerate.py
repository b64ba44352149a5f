def family(_folder, _seed):
    return []
