// Which bounds of what has not been read the rays of a thread have met: a bit for each box of an UnreadBounds, in memory
// of whoever traces (render/services.h), so that a ray that meets one neither allocates nor waits. UnreadBounds writes.
#pragma once
#include <cstddef>
#include <cstdint>

namespace kinora::trace {

struct UnreadNotes {
  uint64_t* words = nullptr;  // null: nobody asks which
  size_t count = 0;
  static UnreadNotes& ofThread();
};

}  // namespace kinora::trace
