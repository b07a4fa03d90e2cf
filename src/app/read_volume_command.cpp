// What the program does when it has started itself to read a file of volumes.
#include "app/commands.h"
#include "volume/read_process.h"

namespace kinora::app {

int runReadVolume(const Arguments& arguments) { return volume::serveGrid(arguments); }

}  // namespace kinora::app
