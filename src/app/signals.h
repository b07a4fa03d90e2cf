// Signals and time limits as flags that the reader looks at between requests and the renderer between buckets. Used
// by the render command. A second SIGINT or SIGTERM ends the program at once.
#pragma once
#include <atomic>

namespace kinora::app {

// Installs the handlers and returns the flag that SIGINT and SIGTERM set. Writing to a closed pipe or over a file
// size limit becomes an error of the write instead of the program's end.
std::atomic<bool>* stopOnSignals();
// The flag that SIGUSR1 sets: write the picture so far and go on.
std::atomic<bool>* snapshotOnSignal();
// Sets the stop flag after so many seconds, once.
void stopAfter(double seconds);

}  // namespace kinora::app
