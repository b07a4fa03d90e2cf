// What an archive's bytes mention, without reading it as RIB: whether it is worth looking for lights in it. Called by
// the interpreter for archives that would wait (procedurals.cpp). It may see what is not there (a comment, a name), and
// misses nothing that is.
#pragma once
#include "rib/byte_source.h"

namespace kinora::rib {

struct Mentions {
  bool lights = false;      // Light, LightSource, AreaLightSource
  bool archives = false;    // others that it reads, which may hold lights
  bool objects = false;     // instances of objects, which may hold lights
  bool conditions = false;  // it says different things in different places
};
// Reads to the end, or as far as it can be read.
Mentions mentionsIn(ByteSource& source);

}  // namespace kinora::rib
