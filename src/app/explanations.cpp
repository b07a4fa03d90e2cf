#include "app/explanations.h"

#include "film/messages.h"
#include "geometry/tessellate.h"
#include "render/messages.h"
#include "rib/reader.h"
#include "shade/messages.h"

namespace kinora::app {

namespace {

constexpr Explanation kOwn[] = {
    {"APP-OPTION",
     "The command line does not say what to do: an option is unknown, lacks its value, or has one of the wrong form. "
     "Nothing was done and the exit code is 2. `kinora COMMAND --help` lists the options of a command."},
    {"APP-TXMAKE",
     "kinora maketex was given a flag of txmake that it takes and does not follow: the width of the filter (-blur), "
     "levels that are smaller in one direction alone (-pattern all), a choice of channels (-ch). The texture is made "
     "without it."},
    {"APP-MEMORY",
     "The system refused memory. Exit code 5. Fewer pixels, fewer channels or a simpler scene need less; -v and "
     "--stats "
     "say what takes the most in a frame that fits."},
    {"APP-INTERNAL",
     "Kinora met a state that its authors held to be impossible. Exit code 8. The message repeats the command; a "
     "report "
     "with the scene lets it be found."},
    {"APP-LIBRARY",
     "libkinora_pictures.so, which lies in lib/kinora beside the program's folder, is missing, belongs to another "
     "version "
     "or lacks one of the shared libraries that OpenImageIO brings. Textures, light maps, volumes and all picture "
     "files "
     "but OpenEXR ones need it. Exit code 8: the scene is not at fault. Install Kinora anew, as a whole; the message "
     "says what the system's loader found missing."},
    {"APP-WRITE",
     "A file or standard output cannot be written: the folder is missing, permission is refused, the disk is full, "
     "or the "
     "name is that of something other than a file. Exit code 6. Files are written under a temporary name and "
     "renamed, so "
     "a file of the name that existed before is still whole."},
    {"APP-STRICT",
     "With --strict a missing texture, archive or plug-in is an error: the exit code is 4 and the frame is not "
     "rendered. "
     "The messages before this one name each asset. Without --strict a visible fallback stands in for it."},
    {"APP-STOPPED",
     "SIGINT, SIGTERM or --max-time ended the program before there was a picture: while the scene was read or built. "
     "Exit code 7; files of the names asked for are what they were before."},
    {"APP-FRAMES",
     "--frames names frames that the scene does not have. Those it has are rendered; the exit code is 3, so that a "
     "farm "
     "notices. The number is the one after FrameBegin; worlds outside FrameBegin ... FrameEnd count from 0."},
    {"APP-SAME-FILE",
     "Two frames of the scene would be written to one file, and the second would take the place of the first. The "
     "first "
     "is written and kept; the second is not rendered, the frames after it go on, and the exit code is 3. A name "
     "with "
     "#### gets the frame's number: Display \"name.####.exr\", or -o name.####.exr. --frames N renders one of them."},
    {"APP-SHADOW-PASS",
     "Renderers of shadow maps need depths as the lights see them before the picture: frames whose only displays are "
     "of the drivers shadow, deepshad or zfile. Here shadows are traced, lights that name such maps included, and "
     "the "
     "frame is left out where the stream has others. Alone, or picked by --frames, it is rendered; so it is with a "
     "display of another driver, such as Display \"depth.exr\" \"openexr\" \"z\"."},
    {"MEMORY-LIMIT",
     "What the frame needs does not fit into --memory-limit. Sizes are counted before they are taken: the scene "
     "description while it is read, meshes, the hierarchies that rays are traced in, the picture's sums and the "
     "textures "
     "held; the message names the largest. Exit code 5. Fewer pixels or channels make the film smaller, a larger "
     "dice:micropolygonlength the meshes; the texture cache shrinks by itself to what is left."},
    {"MEMORY-RECORDS",
     "PxrVCM and PxrUnified keep vertices and beams of light paths while camera paths look for them. There is less "
     "room "
     "for them than they would take (three eighths of what --memory-limit leaves before the first pass), so that "
     "only "
     "some light paths are kept. The picture has the same mean and more noise. keptPaths of the integrator says how "
     "many "
     "are kept in any case."},
    {"APP-CPU", "Kinora's kernels need AVX2, FMA, BMI2 and F16C (x86-64 processors since about 2013). Exit code 9."},
    {"CLI-SET",
     "--set takes KIND.NAME=VALUE. KIND is integrator, hider, projection, option, light or display; NAME is a "
     "parameter "
     "of that kind, for options GROUP:NAME; VALUE is a number, three numbers separated by commas, or text. A NAME "
     "that nothing of the kind has is a mistake, and so are options that act while the scene is read, which is "
     "before. Exit code 2."},
    {"CLI-SET-READ",
     "--set option.user:NAME=VALUE holds for what is asked while the frame is rendered. Conditions (IfBegin) are "
     "decided while the scene is read, by the scene's own Option \"user\"; a file that stands before the scene on "
     "the "
     "command line can say it for them."},
};

// Messages of rooms that have no table of their own.
constexpr Explanation kRooms[] = {
    {"PLUGIN-LOAD",
     "A library on the plug-in path cannot be used. It was built for another version of the plug-in interface, does "
     "not "
     "export its descriptor, has no functions that this CPU runs, or failed while being asked. It is ignored; a "
     "scene "
     "that names it gets a visible fallback. Build it again against this Kinora's headers."},
    {"PLUGIN-DUPLICATE",
     "Two plug-ins have one name and kind. The first one found is used: a stock plug-in before libraries, and "
     "directories "
     "in the order --plugin-path, KINORA_PLUGIN_PATH, the installed folder."},
    {"PLUGIN-MISSING",
     "The scene names a plug-in that is neither in stock nor a library on the plug-in path. Something visible stands "
     "in: "
     "a plain material, PxrPathTracer for an integrator; an unknown light gives none. Colours that an unknown "
     "pattern "
     "feeds are what the scene says to it: its colour of the output's name (Cin for Cout), else the image that it "
     "names, else its first colour. `kinora plugins` lists what "
     "there "
     "is; --plugin-path names more folders. With --strict the exit code is 4."},
    {"PLUGIN-STAND-IN",
     "The plug-in that the scene names is not in stock; the message names the one that stands in and how: a light of "
     "the same "
     "colour, intensity and about the same area, a material of the same colours and roughness. The picture is near "
     "to "
     "what is meant, not equal to it. With --strict the exit code is 4."},
    {"ASSET-MISSING-ARCHIVE",
     "ReadArchive names a file that is not found beside the scene, on the scene's archive search path, or under "
     "--search-path archive=DIRS. What it would have held is left out."},
    {"ASSET-TEXTURE-MISSING",
     "A texture file is not found beside the scene, on the scene's texture search path, or under --search-path "
     "texture=DIRS. The pattern's missingColor is shown; where that is magenta, its default, a checkerboard of two "
     "greys."},
    {"ASSET-TEXTURE-DECODED",
     "A pattern reads a file of floating-point numbers with linearize 1, which decodes them from sRGB. Most such "
     "files, "
     "and those that `kinora maketex --linearize` makes, hold light: decoded once more their colours are too dark. "
     "linearize 0 is for them. Where the file does hold encoded colours nothing is wrong."},
    {"ASSET-TEXTURE-UNPREPARED",
     "A texture has no coarse levels; they are made while rendering, which takes time and memory, not quality. With "
     "--texture-folder each file is prepared once, and no value changes. Or prepare it with `kinora maketex`; a "
     "picture "
     "that the scene reads with linearize 1 with `--linearize`, and then read it with linearize 0: coarse levels of "
     "a "
     "plain one are averages of encoded colours, too dark where these are decoded."},
    {"ASSET-TEXTURE-",
     "A texture file was found but not all of it can be used: it cannot be read, lacks the channels asked for, or "
     "had to "
     "be converted on the fly. The message says what stands in for it."},
    {"ASSET-VOLUME-MISSING",
     "A volume file that a shader names in texture3d() is not found beside the scene, on the scene's texture search "
     "path, or "
     "under --search-path texture=DIRS. Lookups give the call's missingcolor, else black. With --strict the exit "
     "code is 4."},
    {"ASSET-VOLUME-READ",
     "A volume file was found but cannot be used: it is no OpenVDB file, it is damaged, it has no such grid (grids "
     "of single "
     "floats and of triples of them are read, with linear transforms), or it does not fit into memory. Such files "
     "are read in a "
     "process of their own, so that a damaged one cannot end the frame; that process has a limit of time: a minute, "
     "and more "
     "for large files. Lookups give the call's missingcolor, else black. With --strict the exit code is 4."},
    {"ASSET-COLOR-CONFIG",
     "The environment names an OpenColorIO configuration ($OCIO) that is missing, broken, or has no role "
     "scene_linear. "
     "Colours are what they are without one: the working space is linear light with the primaries of sRGB and "
     "Rec.709, "
     "textures of 8 bits are sRGB where they are linearized, PNG, JPEG and TIFF are sRGB-encoded. With --strict the "
     "exit "
     "code is 4."},
    {"VOLUME-CACHE",
     "Grids of volumes take more than --volume-cache (Option \"limits\" \"int brickmemory\" in KiB, or half of the "
     "memory limit) and lie in a file from there on, in the folder that TMPDIR names, else in /tmp or /var/tmp. That "
     "file cannot be made or has no room, so that they are held in memory. The picture is the same."},
    {"IMAGE-COMPARE",
     "Two pictures cannot be compared: their sizes differ, or no channel has the same name in both."},
    {"IMAGE-", "A picture file cannot be opened, read, understood or written; the message gives the reason."},
};

}  // namespace

Explanations allExplanations() {
  Explanations all;
  all.add(kOwn);
  all.add(kRooms);
  all.add(rib::explanations());
  all.add(geometry::explanations());
  all.add(film::explanations());
  all.add(shade::explanations());
  all.add(render::explanations());
  return all;
}

}  // namespace kinora::app
