#include "app/commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>

#include "app/command_line.h"
#include "app/exit_codes.h"
#include "base/diagnostics.h"
#include "image/picture_library.h"
#include "render/version.h"
#include "volume/read_process.h"

namespace kinora::app {

const std::vector<Command>& commands() {
  static const std::vector<Command> list{
      {"render", "render RIB files (the command may be left out)", &runRender},
      {"plugins", "list plug-ins, or the parameters of one", &runPlugins},
      {"info", "what a scene or an image holds", &runInfo},
      {"diff", "compare two images", &runDiff},
      {"maketex", "make a tiled, mip-mapped texture of an image", &runMaketex},
      {"merge", "add the parts of one frame that --samples wrote", &runMerge},
      {"rib", "convert RIB between ASCII, binary and gzip, expand archives", &runRib},
      {"shader", "compile OSL shaders, show their parameters", &runShader},
      {"explain", "what the code of a message means", &runExplain},
  };
  return list;
}

namespace {

void printHelp(std::FILE* to) {
  fmt::print(to, "Kinora {}: a production path tracer\n\n", kVersion);
  fmt::print(to, "  kinora [render] [options] FILE.rib ...\n  kinora COMMAND [options]\n\nCommands:\n");
  for (const Command& c : commands()) fmt::print(to, "  {:<10}{}\n", c.name, c.help);
  fmt::print(to, "\n`kinora COMMAND --help` shows a command's options, `kinora --version` the version.\n");
}

int dispatch(const Arguments& arguments) {
  if (arguments.empty()) {
    printHelp(stderr);
    return kBadCommandLine;
  }
  const std::string& first = arguments.front();
  if (first == "--help" || first == "-h" || first == "help") {
    printHelp(stdout);
    return kComplete;
  }
  if (first == "--version") {
    fmt::print("kinora {}\n", kVersion);
    return kComplete;
  }
  for (const Command& c : commands())
    if (first == c.name) return c.run({arguments.begin() + 1, arguments.end()});
  for (const char* later : {"denoise", "view"})
    if (first == later) {
      Diagnostics diagnostics;
      return badCommandLine(diagnostics, "the command '" + first + "' is not available yet", "see `kinora --help`");
    }
  // this program, started by itself; no help names it
  if (first == volume::kReadCommand && arguments.size() == 5)
    return volume::serveGrid({arguments.begin() + 1, arguments.end()});
  return runRender(arguments);
}

// The line that repeats what was run, for a report of an internal error.
std::string quoted(const Arguments& arguments) {
  std::string line = "kinora";
  for (const std::string& a : arguments)
    line += a.find_first_of(" '\"$\\*?") == std::string::npos ? " " + a : fmt::format(" '{}'", a);
  return line;
}

}  // namespace

int runProgram(const Arguments& arguments) {
  int code = kInternal;
  try {
    code = dispatch(arguments);
  } catch (const std::bad_alloc&) {
    Diagnostics().error("APP-MEMORY", {}, "out of memory", "stopped", "render fewer pixels or simplify the scene");
    code = kOutOfMemory;
  } catch (const std::exception& e) {
    if (std::ferror(stdout)) {  // printing has failed, not the program
      Diagnostics().error("APP-WRITE", {}, std::string("standard output cannot be written: ") + e.what());
      return kCannotWrite;
    }
    Diagnostics().error("APP-INTERNAL", {}, std::string("internal error: ") + e.what(), "stopped",
                        "please report it with the scene and this command: " + quoted(arguments));
  } catch (...) {
    Diagnostics().error("APP-INTERNAL", {}, "internal error of an unknown kind", "stopped",
                        "please report it with the scene and this command: " + quoted(arguments));
  }
  if (const std::string problem = image::pictureLibraryProblem(); !problem.empty()) {
    Diagnostics().error("APP-LIBRARY", {}, problem, "what needs it was not done", "install Kinora anew, as a whole");
    code = kInternal;
  }
  // a full disk behind standard output shows only now
  if ((std::fflush(stdout) != 0 || std::ferror(stdout)) && code == kComplete) {
    Diagnostics().error("APP-WRITE", {}, std::string("standard output cannot be written: ") + std::strerror(errno));
    code = kCannotWrite;
  }
  return code;
}

}  // namespace kinora::app
