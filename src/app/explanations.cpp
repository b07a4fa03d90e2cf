#include "app/explanations.h"

#include "rib/reader.h"

namespace kinora::app {

namespace {

constexpr Explanation kOwn[] = {
    {"APP-OPTION",
     "The command line does not say what to do: an option is unknown, lacks its value, or has one of the wrong form. "
     "Nothing was done and the exit code is 2. `kinora COMMAND --help` lists the options of a command."},
    {"APP-MEMORY",
     "The system refused memory. Exit code 5. Fewer pixels, fewer channels or a simpler scene need less; -v and "
     "--stats "
     "say what takes the most in a frame that fits."},
    {"APP-INTERNAL",
     "Kinora met a state that its authors held to be impossible. Exit code 8. The message repeats the command; a "
     "report "
     "with the scene lets it be found."},
    {"APP-WRITE",
     "A file or standard output cannot be written: the folder is missing, permission is refused, the disk is full, "
     "or the "
     "name is that of something other than a file. Exit code 6. Files are written under a temporary name and "
     "renamed, so a "
     "file of the name that existed before is still whole."},
    {"APP-STRICT",
     "With --strict a missing texture, archive or plug-in is an error: the exit code is 4 and the frame is not "
     "rendered. "
     "The messages before this one name each asset. Without --strict a visible fallback stands in for it."},
    {"APP-CPU", "Kinora's kernels need AVX2, FMA, BMI2 and F16C (x86-64 processors since about 2013). Exit code 9."},
    {"PLUGIN-LOAD",
     "A library on the plug-in path cannot be used. It was built for another version of the plug-in interface, does "
     "not "
     "export its descriptor, has no functions that this CPU runs, or failed while being asked. It is ignored; a "
     "scene that "
     "names it gets a visible fallback. Build it again against this Kinora's headers."},
    {"PLUGIN-DUPLICATE",
     "Two plug-ins have one name and kind. The first one found is used: a stock plug-in before libraries, and "
     "directories "
     "in the order --plugin-path, KINORA_PLUGIN_PATH, the installed folder."},
};

}  // namespace

Explanations allExplanations() {
  Explanations all;
  all.add(kOwn);
  all.add(rib::explanations());
  return all;
}

}  // namespace kinora::app
