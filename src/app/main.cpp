// The program `kinora`: checks that this CPU can run the kernels, then hands over to the command.
#include <cstdio>

#include "app/commands.h"
#include "app/exit_codes.h"
#include "simd/dispatch.h"

int main(int count, char** values) {
  if (!kinora::cpuHasAvx2()) {
    std::fputs(
        "kinora: error APP-CPU: this CPU lacks AVX2, FMA, BMI2 or F16C; stopped; Kinora needs an x86-64 CPU of "
        "2013 or later\n",
        stderr);
    return kinora::app::kUnsupportedCpu;
  }
  return kinora::app::runProgram({values + 1, values + count});
}
