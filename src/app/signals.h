// SIGINT and SIGTERM as a flag that the renderer looks at between buckets. Used by the render command. A second
// signal ends the program at once.
#pragma once
#include <atomic>

namespace kinora::app {

// Installs the handlers and returns the flag they set. Writing to a closed pipe or over a file size limit becomes an
// error of the write instead of the program's end.
std::atomic<bool>* stopOnSignals();

}  // namespace kinora::app
