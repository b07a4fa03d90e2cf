// The commands of the program, one source file each. Called by main.cpp with the arguments after the command's name;
// each returns an exit code (exit_codes.h). They print results on standard output and messages on standard error.
#pragma once
#include <string>
#include <vector>

namespace kinora::app {

using Arguments = std::vector<std::string>;

int runRender(const Arguments& arguments);
int runPlugins(const Arguments& arguments);
int runInfo(const Arguments& arguments);
int runDiff(const Arguments& arguments);
int runMaketex(const Arguments& arguments);
int runMerge(const Arguments& arguments);
int runRib(const Arguments& arguments);
int runExplain(const Arguments& arguments);
int runShader(const Arguments& arguments);

struct Command {
  const char* name;
  const char* help;
  int (*run)(const Arguments&);
};
const std::vector<Command>& commands();

// Finds the command that the arguments ask for (`render` when they name none) and runs it. No exception leaves it.
int runProgram(const Arguments& arguments);

}  // namespace kinora::app
