// How long this process has run, dynamic linking included: what a user waits for is counted from there.
#pragma once

namespace kinora {

// Seconds since the process was started, in steps of the kernel's clock ticks (10 ms); -1 when the system does not
// say.
double processAge();

}  // namespace kinora
