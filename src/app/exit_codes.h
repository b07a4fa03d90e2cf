// What the program's exit status says; scripts and farms depend on the numbers, so they never change. Used by every
// command. It decides nothing: each command returns the code of what happened to it.
#pragma once

namespace kinora::app {

enum ExitCode : int {
  kComplete = 0,
  kDiffers = 1,  // `diff` only: over a threshold
  kBadCommandLine = 2,
  kBadScene = 3,      // cannot be read, or holds nothing to render
  kMissingAsset = 4,  // under --strict
  kOutOfMemory = 5,
  kCannotWrite = 6,
  kInterrupted = 7,  // what was asked to be kept was kept
  kInternal = 8,
  kUnsupportedCpu = 9
};

}  // namespace kinora::app
