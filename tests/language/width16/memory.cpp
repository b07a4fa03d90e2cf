#include "language/width16/pair.h"

#include "language/vm/memory.cpp"
