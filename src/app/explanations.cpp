#include "app/explanations.h"

#include "geometry/tessellate.h"
#include "rib/reader.h"

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
    {"LIGHT-PORTAL",
     "A PxrPortalLight shows a dome through a rectangle: the PxrDomeLight whose lightColorMap is the portal's "
     "domeColorMap, else the first dome of the scene. Without either it is an even light of its own colour. A "
     "portalToDome that is no matrix leaves the dome standing as the portal does."},
    {"BXDF-LAYERS",
     "A material is a tree of bxdfs (LamaSurface, LamaLayer, LamaMix, LamaAdd) that cannot be kept as it is: it has "
     "more than eight leaves (four with hair), a leaf is no Lama slab, hair is layered or stands beside other slabs "
     "than "
     "LamaDiffuse and LamaTranslucent, nothing is connected, the back differs from the front, or a "
     "structure written by hand is no tree. The "
     "message says what is done. `kinora plugins LamaSurface` has the rules."},
    {"SHADER-COMPILE",
     "A file of the shading language was found for a pattern and cannot be compiled, or it is compiled by a version "
     "or a tool "
     "whose text is not understood; the errors follow with file, line and column. What the shader feeds is magenta "
     "where it is "
     "a colour and has its default elsewhere. `kinora shader compile FILE` says the same without rendering."},
    {"PATTERN-PRIMSTR",
     "The name of a file in a material holds the token <primstr:NAME>, which stands for the constant string primvar "
     "NAME of "
     "each object, and an object with that material has none. The token stays in the name, and the file is mostly "
     "not found."},
    {"PATTERN-BUMP",
     "inputBump of a PxrBump is connected to something that has no slopes here: patterns give values, not how these "
     "change along the surface, and normals stay as they are. What works: `filename` of PxrBump; a PxrTexture at "
     "inputBump whose colorScale, colorOffset and saturation no pattern feeds (the bump reads its file itself); a "
     "height that an OSL shader computes; or displacement."},
    {"PATTERN-RAMP",
     "The ramp of a pattern has more knots than colours or fewer, or knots that do not ascend. Knots and colours go "
     "together by number; what is left over is not used, and a knot that lies before the one ahead of it ends no "
     "piece of the ramp."},
    {"PATTERN-COORDSYS",
     "A pattern, material or displacement has a parameter that names a coordinate system, and nothing in the scene "
     "gives "
     "that name: no CoordinateSystem or ScopedCoordinateSystem in the world, none in the definition of an object. "
     "What it "
     "computes stays in the world's space. Names are case-sensitive."},
    {"PATTERN-EXPRESSION",
     "The expression of a PxrSeExpr node is not understood; the message says what is wrong, with line and column "
     "within "
     "the expression. It is assignments (name = value;) and conditions (if (...) { ... } else { ... }), then the "
     "result "
     "without a name. What the node feeds is magenta where it is a colour and has its default elsewhere. "
     "`kinora plugins PxrSeExpr` lists the variables."},
    {"SHADER-OSO",
     "A compiled shader (.oso) was found and cannot be used: it is damaged, of a version that is not known, or made "
     "by "
     "a tool "
     "whose text is not understood; the message says where. The source of the same name stands beside it and is "
     "compiled "
     "in its place, so that the picture is as it should be. Removing the .oso file, or writing it again with `kinora "
     "shader compile`, ends the message."},
    {"SHADER-CALL",
     "A shader calls something that this renderer does not grant: trace(), because integrators do not let shaders "
     "trace rays. "
     "The call answers as if nothing were there. The message stands once for each kind of call."},
    {"SHADER-COORDSYS",
     "A shader transforms to or from a coordinate system by a name that nothing in the scene gives: no "
     "CoordinateSystem, "
     "no object that is being shaded. What it transforms stays as it is, and getmatrix() returns 0. Names are told "
     "once "
     "each."},
    {"SHADER-DICTIONARY",
     "dict_find() of a shader was given a text that is no XML or a query that is no XPath; the message says what is "
     "wrong. "
     "Nothing is found in it."},
    {"SHADER-CLOSURE",
     "A shader makes closures (diffuse(), emission() ...), as surface shaders of other renderers do. Here shaders "
     "are patterns: "
     "they compute colours and numbers, and a Bxdf scatters the light. The closure has no value and Ci no effect; "
     "connect the "
     "shader's other outputs to a Bxdf."},
    {"SHADER-RECOMPILED",
     "The scene was edited, and a file of a shader has changed since it was compiled (the shader's own, or one that "
     "it "
     "includes): the new text is what is rendered from now on."},
    {"SHADER-CACHE",
     "Option \"shader\" \"int cache\" [1] asks for compiled shaders beside their sources (NAME.oso beside NAME.osl), "
     "and that "
     "folder cannot be written. Rendering does not need it: shaders are compiled in memory, in milliseconds."},
    {"SHADER-GROUP",
     "Shaders that feed each other cannot run as one program: a connection between types that do not fit, a cycle, "
     "or an "
     "operation that this renderer refuses. What they feed uses its defaults."},
    {"SHADER-OUTPUT",
     "A string, a matrix or an array of a shader is connected to a parameter of a plug-in, which takes numbers, "
     "colours, "
     "points, vectors and normals. The parameter's default is used."},
    {"SHADER-ERROR", "A shader called error(). The text is its own; rendering goes on with what it computes."},
    {"SHADER-WARNING",
     "A shader called warning(), or an index ran out of an array and was clamped. The text says which."},
    {"SHADER-PRINT", "A shader called printf()."},
    {"PLUGIN-CREATE",
     "A plug-in was found but could not be set up; the message says why. What is used instead is what would be used "
     "if "
     "there were no such plug-in."},
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
    {"PARAM-UNKNOWN",
     "A node is given a parameter that its plug-in does not have; it is ignored. `kinora plugins NAME` lists those "
     "it "
     "has. Often a misspelling, or a parameter of a newer or older version of the plug-in of that name."},
    {"PARAM-TYPE", "A parameter's value has another type or length than its plug-in declares. The default is used."},
    {"PARAM-IMAGE", "A plug-in is told to show an image and is given no name of one. The message says what is seen."},
    {"PARAM-NO-EFFECT",
     "A plug-in takes a parameter so that scenes are read, and does nothing with it; the scene sets it to something "
     "other than its default. `kinora plugins NAME` shows which these are (\"No effect\"), and what to use instead "
     "where there is something. Of materials and patterns each parameter of a plug-in is told once, at the first "
     "node "
     "that sets it."},
    {"PARAM-CHOICE",
     "A parameter whose numbers or words stand for choices (a blend mode, a type of noise, a variable) has one that "
     "stands for none. The message says what is done and, as `kinora plugins NAME`, lists the choices."},
    {"PARAM-",
     "A parameter of a node, or what is connected to it, cannot be used as the scene says. The message says what was "
     "done "
     "instead; `kinora plugins NAME` shows types, ranges and what can be connected."},
    {"LIGHT-",
     "A light is set up in a way that gives no or other light than may be meant: a degenerate transform or size, a "
     "map "
     "that cannot be read, an angle outside its range. The message says what was done."},
    {"PROJECTION-",
     "A camera parameter cannot be used: a field of view outside 0 to 180 degrees, or a lens that cannot exist. The "
     "message says what is used instead."},
    {"DISPLAY-FOLDER",
     "With -o, further pictures of the scene whose folder does not exist here are written beside the first one, "
     "under their "
     "own names."},
    {"RENDER-MEMORY", "There is not enough memory for the scene or the picture. Exit code 5."},
    {"RENDER-RESOLUTION",
     "Format, or --res, asks for a picture beyond what Kinora renders: 65,536 pixels on a side and 2^31 in all. Exit "
     "code 3."},
    {"RENDER-BLACK",
     "All of a finished picture's colour is 0. Either the camera sees no object (alpha is 0 everywhere; matte "
     "objects hold out and count "
     "for none), or no light reaches those that it sees. Messages before this one often say what was left out."},
    {"RENDER-SAMPLES",
     "The Hider's maxsamples is negative or more than 65,536. A negative one is ignored: PixelSamples, then 64, say "
     "how "
     "many samples a pixel has. Or its samplestride is not within 1 to 4,096: then every sample is taken."},
    {"RENDER-ADAPTIVE",
     "Adaptive sampling cannot be done as it is asked for. With a least number of samples (minsamples, --min-spp) "
     "above the most, every pixel takes the most. A part of a frame's samples (--samples) takes all of them in every "
     "pixel, for what earlier samples would have decided is not known to it: such parts merge to the picture without "
     "adaptive sampling, and so is a frame whose Hider takes one of several samples (samplestride). Parts by --crop "
     "decide as the whole frame does."},
    {"RENDER-NOISE",
     "--error asks for a picture whose relative error (root mean square over the pixels, as two halves of the "
     "samples "
     "differ) is at most so much, and the samples that --max-spp allows did not suffice. The picture is complete "
     "otherwise."},
    {"RENDER-CHECKPOINT",
     "A checkpoint (--checkpoint, Option \"checkpoint\") could not be written, or the scene says no time for them "
     "that "
     "can be read. The render goes on; if it is stopped, --recover finds the last checkpoint that was written."},
    {"RENDER-CHECKPOINT-COMMAND",
     "Option \"checkpoint\" \"string command\" names a program to run after each checkpoint. Scenes run programs "
     "with "
     "--allow-exec alone; a program that ends with another code than 0 is told, and the render goes on."},
    {"RENDER-RECOVER",
     "--recover found a checkpoint that this frame cannot go on from: of another scene, another seed or frame, other "
     "settings of adaptive sampling or more samples than are asked for, or a file that is broken. The message says "
     "which. The frame is rendered from its first sample, and its own checkpoints take the place of that file."},
    {"RENDER-RECOVERED",
     "--recover found a checkpoint of this frame. Its samples are not taken again, and the picture has the bits of a "
     "render that was never stopped."},
    {"RENDER-CROP",
     "CropWindow, or --crop, rounded to pixels as RIB says, is empty: a pixel belongs to the window that holds its "
     "top "
     "left corner, and narrow windows may lie between two of them. Nothing is rendered; the exit code is 3, or 2 "
     "where "
     "the command line named the window."},
    {"RENDER-PROCEDURAL-BOUND",
     "A procedural holds things outside of the bound that its request says. It is read when a ray first meets the "
     "bound: "
     "rays that pass the bound and would meet what lies outside find it only once other rays have had it read, so "
     "that "
     "parts of the picture may lack it. The message says by which factor the bound must be larger. "
     "--read-procedurals "
     "reads all of them first."},
    {"RENDER-PROCEDURAL-BUDGET",
     "Archives and programs that are read when rays meet them are dropped and read again where they do not fit in "
     "their "
     "budget together (--geometry-cache, Option \"limits\" \"int geocachememory\" in KiB, or a half of "
     "--memory-limit). "
     "Paths are followed in groups, of which a small one has 16. Some of these meet more at the same time than the "
     "budget holds, so that it is passed for their sake. The picture is the same. Integrators that keep records of "
     "light paths (PxrVCM, PxrUnified with traceLightPaths) hold all that was read, and say so where it is more."},
    {"RENDER-PROCEDURAL-CHANGED",
     "An archive, or what a program prints, is not what it was when it was first read for this frame: it had been "
     "dropped "
     "to keep a budget of memory, and was read again. What it gives now is used from there on. Samples that were "
     "taken "
     "before saw what it gave before, and parts of the frame do not merge with others. Each file is named once."},
    {"RENDER-FLAT",
     "An object, or one placing of it, has a transformation that leaves it no volume to speak of, or makes it so "
     "small or "
     "puts it so far away that no ray can be brought into its space. It is left out there. What only passes such a "
     "moment "
     "while it moves, as something that turns inside out, is drawn: rays keep a millionth of the shutter's time "
     "away."},
    {"RENDER-FRAME-ASPECT",
     "--res asks for a picture of another shape than the scene's FrameAspectRatio. As with Format, the picture is "
     "the "
     "largest part of what is asked for that has the scene's shape: nothing is squeezed, and what is seen stays the "
     "same."},
    {"RENDER-SHUTTER",
     "The numbers of the shutter's opening shape (shutterOpenTime, shutterCloseTime and shutteropening of a Camera, "
     "or "
     "shutteropening of the Hider) do not lie in 0 to 1, are in the wrong order or too few. The shutter opens and "
     "closes "
     "at once."},
    {"RENDER-SOLID",
     "A solid (SolidBegin ... SolidEnd) cannot be resolved as said. Each primitive solid has to be closed: lines "
     "through it "
     "that leave it less often than they enter tell of a hole, as of a Cylinder without its Disks, and a Disk or "
     "curves "
     "alone enclose nothing. Then, and when a difference has nothing to take away from or a solid has more than 8192 "
     "parts or "
     "one that is scaled or placed beyond a billion, "
     "all surfaces of that solid are drawn as they are. Operands without any surface are left out."},
    {"RENDER-TRACE-SET",
     "A subset of objects for rays (trace:reflectsubset, shadowsubset, transmitsubset and their exclude forms) names "
     "a "
     "group that no object is a member of (grouping:membership), or there are more different subsets than rays can "
     "tell "
     "apart (26; one for shadows counts twice). Names without members select nothing; subsets beyond the limit are "
     "ignored."},
    {"RENDER-TRACE-MEDIUM",
     "trace:shadowsubset, reflectsubset, transmitsubset or one of their exclude forms keeps an object's rays from a "
     "medium that fills space. Subsets choose among surfaces; media are there for the rays of all objects, as their "
     "own visibility:camera, indirect and transmission say."},
    {"RENDER-CAMERA",
     "The camera's transform cannot be inverted or holds NaN: the identity stands in for it. Or its screen window, "
     "near "
     "clipping plane or lens is beyond 1e15, where no ray can begin: the usual one, none, and a pinhole stand in."},
    {"RENDER-NO-CAMERA",
     "The scene has no Projection and no Camera. What RIB says then is an orthographic view along z from the "
     "origin."},
    {"RENDER-NO-LIGHTS",
     "No light of the scene is rendered: there is none, or none that is known. Glowing surfaces still light the "
     "rest; "
     "where nothing glows and no Integrator is named, PxrDefault lights every surface from the eye."},
    {"RENDER-CLASSIC-LIGHT",
     "LightSource and AreaLightSource name light shaders of the time before RIS. The message names the light that "
     "stands in. ambientlight, distantlight, pointlight and spotlight, and shaders with one of these words in their "
     "names, follow the RenderMan Interface Specification; intensity is what a white surface that faces the light "
     "shows (of point and spot at distance 1 in the world). Ambient light casts no shadows and makes no highlights. "
     "Other shaders are known by words in their names (area, env, uber ...), else by the parameters that they are "
     "given: coneangle makes a spot, to a distant light, from a point, lighttype or cuton the controls of Barzel's "
     "model (BarzelLightFilter). Shadow maps are not read: shadows are traced. The shape of an unknown "
     "AreaLightSource emits, all of it together as much as a point light of its intensity; one with a falloff of its "
     "own is not seen itself. An AreaLightSource of the first RIS years (PxrStdAreaLight and its kin) becomes the "
     "modern light of its shape, which takes the place of its geometry; radiance follows intensity and exposure as "
     "they stand."},
    {"CLASSIC-LIGHT-OUT",
     "A LightSource is left out, because nothing is known of it (neither its name nor its parameters say what it "
     "does), or because it stands for light that paths find by themselves: caustics of photon maps, light bounced "
     "between surfaces. Where no other light is left, the scene has a headlight. Those between ObjectBegin and "
     "ObjectEnd are left out as well, and the shapes of area lights there give no light: the lights of an object are "
     "those of the request Light."},
    {"CLASSIC-SURFACE",
     "A Surface names a shader of the RenderMan Shading Language, which Kinora does not run, and it is none of the "
     "standard ones (constant, matte, metal, shinymetal, plastic, paintedplastic, defaultsurface, null; glass). One "
     "of these stands in: by a word in the shader's name (metal, plastic, glass, constant ...), else matte, or "
     "plastic "
     "where Ks or specularcolor is given. Color and Opacity, and of its parameters those that many shaders share, "
     "count as they would there: Ka (at most 1), Kd, Ks, Kr, roughness, specularcolor, a colour by a usual name "
     "(basecolor, "
     "surfacecolor ...), a texture (texturename, mapname ...). "
     "Opacity that differs between channels counts as its mean. Atmosphere fog and depthcue fade these surfaces "
     "by the length of the ray that meets them; not glass, not objects with a Bxdf, not what stands behind all "
     "objects."},
    {"LIGHT-OFF",
     "A LightSource lights what is said after it in its own attribute block, as the RenderMan Interface has it: at "
     "AttributeEnd the list of lights before comes back. This one meets no object. Illuminate HANDLE 1 behind the "
     "block "
     "switches it on for all that follows; a Light of RIS needs none of this."},
    {"SHADER-DISPLACEMENT",
     "A Displace names a shader of the shading language that writes neither P nor N, so that it does nothing to the "
     "surface."},
    {"DISPLACEMENT-BOUND",
     "A displacement moves points farther than Attribute \"displacementbound\" \"float sphere\" says, measured in "
     "the "
     "coordinatesystem that it names (the object's own, if none). Kinora draws all that moves and needs no bound; "
     "renderers that trust it cut holes there. The message says which bound holds the surface. Without a bound "
     "nothing "
     "is checked. Surfaces that are diced where rays ask are looked for within the bound: their points move no "
     "farther, or twice as far at edges and corners, where surfaces that meet at an angle are moved as one."},
    {"DISPLACEMENT-COARSE",
     "A displaced surface asks for more micropolygons than are made of one: it is far larger than what is seen of "
     "it, "
     "or \"dice\" \"float micropolygonlength\" is very small. Its micropolygons are longer than asked for, by what "
     "the "
     "message says, and relief smaller than they are is lost. A surface that is diced where rays ask and has no "
     "displacementbound is diced all over once: 200 million triangles at most. What lies far outside a view without "
     "perspective is "
     "cut "
     "less the farther it is, and far from the eye in others, so that size alone is no reason."},
    {"DISPLACEMENT-LEVELS",
     "A displaced surface asks to be diced where rays ask (Attribute \"dice\" \"int levels\" [1]), and the faces "
     "that it "
     "is made of are hardly larger than micropolygons: nothing coarser could be made of them. It is diced at once, "
     "as "
     "without the attribute."},
    {"GEOMETRY-CACHE-SMALL",
     "The geometry cache (--geometry-cache, Option \"limits\" \"int geocachememory\" in KiB) is smaller than one "
     "patch "
     "of a surface that is diced where rays ask. The picture is the same, but each patch is diced again whenever "
     "another "
     "one was in between."},
    {"VOLUME-CACHE",
     "Grids of volumes take more than --volume-cache (Option \"limits\" \"int brickmemory\" in KiB, or half of the "
     "memory limit) and lie in a file from there on, in the folder that TMPDIR names, else in /tmp or /var/tmp. That "
     "file cannot be made or has no room, so that they are held in memory. The picture is the same."},
    {"DISPLACEMENT-KIND",
     "Curves and points have a displacement. Only surfaces are displaced: polygons, subdivision meshes, patches, "
     "NURBS, "
     "quadrics and blobbies."},
    {"DISPLACEMENT-SCALE",
     "A displacement is measured in lengths of the world or of a space of the scene (PxrDispTransform "
     "dispScaleSpace, or "
     "a shader that moves P), and instances of the object that it moves have different scales. The surface is made "
     "once "
     "for all of them, with the scale of the first: on those that are larger it goes farther, on smaller ones less "
     "far."},
    {"DISPLACEMENT-NOT-FINITE",
     "A displacement gives some points an offset that is not a number, infinite or beyond 1e15 units: a division by "
     "0 "
     "in its patterns, or a texture that holds such values. These points stay where they are without it. "
     "The message says on which face the first one is."},
    {"LIGHT-SHADOW",
     "What a light says of its shadows has no meaning: a shadowColor beyond 0 to 1, a shadowFalloffGamma that is not "
     "above "
     "0, a shadowFalloff without the shadowDistance that it ends at, or a number that is not finite. The message "
     "says "
     "what stands in."},
    {"LIGHT-CONNECTION",
     "A parameter of a light is given as a reference to a pattern. Lights are the same from wherever they are asked "
     "and run no patterns: the parameter has its default. Give its value, a picture (lightColorMap), or make the "
     "surface glow by its material, where patterns run."},
    {"LIGHT-MOTION",
     "A light's transform changes the light's size or shape while the shutter is open, or mirrors it. Lights move "
     "and "
     "turn within a frame, and their filters with them, but keep the size and shape that they have at the middle of "
     "the shutter. Surfaces that glow change those too."},
    {"LIGHT-GEOMETRY",
     "A light has geometry (PxrMeshLight, AreaLightSource) of a kind, or in a state, that lights do not follow: "
     "curves "
     "and points have no surface that light could leave, vertices do not move while the shutter is open, "
     "displacement "
     "and the cuts of solids are those of surfaces alone. The message says which it is and what stands in. An object "
     "that glows by its material has all of these."},
    {"LIGHT-NEAR",
     "The intensityNearDist of a light is negative or no finite number. It is the distance in world units below "
     "which "
     "the light's brightness rises no more; 0 is none."},
    {"LIGHT-LINK",
     "Attribute \"lighting\" \"string subset\" or \"excludesubset\" of an object, or Illuminate, names a light, or a "
     "group of lights, that the scene has not; or \"lightfilter\" \"string subset\" a group that is none of the "
     "linkingGroups of its light filters. An object whose subset names no light at all is lit by none, only by "
     "what other "
     "objects "
     "send it. The message stands once for each name."},
    {"LIGHT-FILTER-SPACE",
     "The coordsys of a light filter names no coordinate system of the scene. CoordinateSystem or "
     "ScopedCoordinateSystem makes one; the light's own space stands in."},
    {"ASSET-IES-MISSING",
     "The file that a light's iesProfile names is nowhere along the search path of textures. The light shines as if "
     "it "
     "named none."},
    {"ASSET-IES-READ",
     "The file that a light's iesProfile names is no IES LM-63 file that can be read: the message says where and "
     "why. "
     "Text up to a line TILT=NONE is free; numbers follow: counts, sizes, angles that ascend, a candela value for "
     "each "
     "pair of angles. Horizontal angles go from 0 to 0, 90, 180 or 360 (or from 90 to 270), vertical ones lie within "
     "0 and 180, for types A and B within -90 and 90. The light shines as if it named no profile."},
    {"LIGHT-FILTER-RAMP",
     "The knots of a light filter's ramp are missing, more than 64, not ascending, or not numbers, or its values are "
     "fewer than its knots. The ramp counts as 1 everywhere; the filter's other settings hold."},
    {"LIGHT-FILTER-MAP",
     "The image of a cookie or gobo filter is not named, holds no texels, or is too large (2^31 numbers). The filter "
     "leaves its light as it is."},
    {"FILTER-REFERENCE",
     "A filter combiner names a filter by a handle that no SampleFilter, DisplayFilter or LightFilter of its kind "
     "(for "
     "lights: in force where the Light stands) has, or the handle "
     "of a combiner that names it in turn. It is left out; the "
     "others run in the order in which the combiner names them."},
    {"FILTER-FILM",
     "filmMinX, filmMinY, filmMaxX and filmMaxY of a filter that lays a picture behind or over the frame leave no "
     "window: a minimum is not below its maximum. The message says what is done instead."},
    {"FILTER-PICTURE",
     "A filter that lays a picture behind or over the frame has none: 'filename' is empty, or the picture has no "
     "pixels "
     "or more than 131,072 on a side. The filter does nothing."},
    {"LIGHT-CHANNEL",
     "A light that marks what it is linked to (PxrAovLight) names a channel that no Display holds. It marks nothing. "
     "Add "
     "DisplayChannel \"float mask\" and a Display of \"mask\", with the light's aovName as the channel's name or "
     "source."},
    {"FILTER-SPLATS",
     "Sample filters change what the camera's paths bring, sample by sample. Paths from the lights (PxrVCM, "
     "PxrUnified "
     "with light paths) bring light to pixels of the finished picture, which no sample filter sees."},
    {"FILTER-CHANNEL",
     "A sample or display filter works on a channel (its parameter aov, for instance) that no Display of the frame "
     "holds. The filter runs without it."},
    {"RENDER-INSTANCE-GONE",
     "An instance is of an object that the scene does not have, as after an edit that removed the object alone. The "
     "instance is left out."},
    {"RENDER-EMPTY",
     "A frame was read whose world has no object and no light: nothing stands between WorldBegin and WorldEnd, or "
     "all of "
     "it was refused. Its picture is written, empty, and the program ends with code 3, as for a file without a "
     "scene; "
     "further frames are rendered."},
    {"RENDER-NO-WORLD",
     "A picture was asked for after a load or an update that gave nothing to render. The messages before say why."},
    {"EDIT-EMPTY",
     "An edit left an empty place in a list of the scene. It is taken out, as if the thing had been erased."},
    {"EDIT-TRANSFORM",
     "An edit left a transform with another number of times than matrices, or with times that do not rise. Its first "
     "matrix is used, or the identity where it has none."},
    {"RENDER-INSTANCES", "Instances inside instances multiply; beyond a bound the rest is left out."},
    {"RENDER-LEARNING",
     "An integrator of a plug-in declares that it learns (IntegratorTraits::learning), but has stages besides camera "
     "paths, keeps records between stages, or lacks IntegratorFunctions::learn. The frame is rendered with nothing "
     "learned; its bits do not depend on parts or crops either way."},
    {"RENDER-RECORDS",
     "An integrator keeps records from one stage of a pass for the next, in lists that it declares. It appended to a "
     "list that does not exist or that another stage writes; those records were dropped. A fault of the plug-in."},
    {"MEDIUM-AGGREGATE",
     "An integrator (volumeAggregate, volumeAggregateCamera, volumeAggregateIndirect, volumeAggregateTransmission) "
     "or a "
     "surface (volumeAggregateName) asks for volumes by the name of an aggregate that no volume is in. Volumes are "
     "put "
     "into aggregates by Attribute \"volume\" \"string[] aggregate\"; those that say nothing are in "
     "\"globalVolumeAggregate\", which integrators ask for by default."},
    {"MEDIUM-BOUND",
     "Distances in a medium are drawn by bounds of its extinction, found by looking at its patterns on a lattice of "
     "points, or by maxDensity of its material. Somewhere the extinction is larger than the bound. The picture is "
     "still "
     "right in the mean, and noisier there: state the true maximum, or make the pattern smoother."},
    {"MEDIUM-ENDLESS",
     "A ray met a medium more than 65,536 times before it came through or was scattered: its density is enormous, or "
     "far "
     "below the bound that was given for it. Such rays count as absorbed."},
    {"MEDIUM-FIELD",
     "A Volume request brings numbers for its voxels, and their count is neither that of its points nor three times "
     "that: the field is left out. Or the fourth string of \"blobbydso:stringargs\" is no dictionary (JSON), or its "
     "\"filterWidth\" no number from 0 to 1000: grids are looked up as without it; other words of it are not known."},
    {"MEDIUM-INTEGRATOR",
     "The scene has fog, smoke or another medium, and its integrator cannot follow light that is scattered there. "
     "Media "
     "absorb what they would scatter, and what they emit is missing. PxrPathTracer, PxrDirectLighting, PxrVCM and "
     "PxrUnified can."},
    {"MEDIUM-LEFT-OUT",
     "Volumes are in aggregates (Attribute \"volume\" \"string[] aggregate\") that the integrator asks for in none "
     "of its "
     "rays, and no surface that encloses something (volumeAggregateName) for its inside: they are left out. Its "
     "volumeAggregate names aggregates, several with blanks between them; "
     "\"globalVolumeAggregate\" is that of volumes that say nothing."},
    {"MEDIUM-NONE",
     "A Volume request has the material of a surface, or none: nothing would fill it. It is left out."},
    {"MEDIUM-OPEN",
     "What has the material of a medium, or has volumes inside (volumeAggregateName), encloses no space. Curves and "
     "points are left out, and have none. A surface with holes, or "
     "one "
     "side of a box as a primitive of its own, bounds its medium as far as it goes: rays that meet it once are "
     "inside "
     "from there on, or were until then."},
    {"MEDIUM-OVERLAP",
     "At one point more than eight media overlap. Those that the ray entered last are left out there."},
    {"MEDIUM-SOLID",
     "A part of a solid (SolidBegin) has the material of a medium, or has volumes inside (volumeAggregateName). What "
     "a "
     "solid leaves of its parts is known for surfaces alone: the medium is left out, the volumes are not inside."},
    {"MEDIUM-VELOCITY",
     "velocityPrimVar of a PxrVolume names no grid or voxels of three components in its Volume request (nor three of "
     "one, \"NAME.x\" and so on): the medium stands still. Or its velocity carries it farther while the shutter is "
     "open "
     "than the medium is large: it is carried by its own size at most. Velocities are in object space, by unit of "
     "the "
     "shutter's time."},
    {"RENDER-PASSES",
     "A ray may pass 256 surfaces that are partly absent (presence), clear to shadows, or inside a medium of higher "
     "priority. Rays that would pass more were given up: camera and indirect rays saw nothing beyond, shadow rays "
     "were "
     "blocked. The message counts them."},
    {"SUBSURFACE-OPEN",
     "Paths that went below a surface with subsurface scattering met nothing of the object there: its mesh is a "
     "sheet, "
     "has a hole or is inside out, or the object is made of curves or points, which have no inside. Their light "
     "comes "
     "out where it went in, as from a diffuse surface of the same colour. The message names the first such object."},
    {"SUBSURFACE-LONG",
     "Paths below a surface made 8,192 free flights, or came far outside of everything through a crack in the mesh. "
     "Their light comes out where it went in. A few of them are harmless; many say that the mean free path is tiny "
     "beside the object while nothing is absorbed, or that the mesh is not closed."},
    {"RENDER-NONFINITE",
     "Some samples gave infinity or not-a-number. They were left out together with their weight, so the pixel is the "
     "mean "
     "of the others. The message names the first; --only-sample X,Y,S prints what its path met."},
    {"LPE-SYNTAX",
     "A light path expression (\"lpe:...\" as the source of a DisplayChannel) is malformed; the message shows where. "
     "The "
     "channel is magenta. An expression begins with C, the camera, and ends with L, a light, or O, a glowing "
     "surface or a light that the camera sees itself; "
     "between stand events: D, S, <RD>, <T[DS]>, <.S'label'>, D2, <L.'group'>, <RD[^'label']>, sets [...], and the "
     "operators | * + ? {n,m} ( ). Before all that may stand unoccluded; (light as if nothing were in its way) or "
     "shadows; (what shadows take of it): both are made of light samples alone, and very noisy on glossy surfaces."},
    {"LPE-",
     "A light path expression is read but cannot be had as it is written: it matches no path, is too large, asks for "
     "what is not told apart. The message says what the channel holds. A light that the camera sees itself is O, "
     "like a "
     "glowing surface, and not L: \"C<L.>\" takes no path, \"CO\" or \"C[<L.>O]\" does, and what sums L and O counts "
     "each "
     "light once. The group of a light stands behind either: \"C.*[<L.'key'><O.'key'>]\"."},
    {"DISPLAY-DRIVER",
     "A Display names a driver that is no plug-in, or a program that shows pictures in a window (framebuffer, it). "
     "The "
     "format is chosen by the file's extension, or openexr stands in."},
    {"DISPLAY-ID",
     "A channel shows identifiers (identifier:id or id2), and some object has one that is negative or has more than "
     "24 "
     "bits. Pictures hold them as floats, so that neighbouring identifiers of that size become one. Number objects "
     "from 0 "
     "to 16,777,216."},
    {"DISPLAY-CAMERA",
     "A display's \"string camera\" names the Camera request whose picture it shows; a frame whose displays name "
     "several is rendered once for each. The message says that there is no camera of that name, or that one run can "
     "give one of them only: --only-sample, and a part (--samples) with a name by -o, are of one picture."},
    {"DISPLAY-SAME-FILE",
     "Two displays of a frame, or a display and -o, name one file, and the second picture would take the place of "
     "the "
     "first. Nothing is rendered. Name a file for each; one display holds any number of channels: "
     "\"Ci,a,z,diffuse\". A "
     "display that shows a window (framebuffer, it) beside a file of its name is not meant: one picture is written."},
    {"DISPLAY-WRITE", "A picture could not be written; the message gives the reason. Exit code 6."},
    {"DISPLAY-",
     "A Display or DisplayChannel asks for something that is not known or not rendered. The message names the "
     "display and "
     "says what is written instead; the other channels and displays are not affected."},
    {"RENDER-NO-SAMPLES",
     "A part of a frame (`kinora render --samples`) was interrupted before every pixel had its first sample. There "
     "is "
     "nothing that could be merged, so no file is written."},
    {"DISPLAY-SNAPSHOT",
     "The picture so far could not be written in the middle of a render, mostly because the disk is full. The file "
     "is "
     "what it was before, the render goes on, and the next snapshot and the end try again."},
    {"FILM-MEMORY",
     "The picture with all its channels does not fit the memory. Exit code 5. Fewer channels need less."},
    {"FILM-FILTER", "The pixel filter is unknown or its width is not usable. gaussian 2 2 is used."},
    {"FILM-MERGE-OVERWRITE",
     "The picture that merge would write has the name of one of the parts, whose samples would be lost. Nothing is "
     "written; the exit code is 2. Give the picture another name with -o."},
    {"FILM-SHARD-SCENE",
     "A part of a frame is of another scene than the parts before it. The message names the first difference: the "
     "object with its file and line in both scenes, or the option, camera, light, texture, shader, volume or "
     "plug-in, "
     "and what of it differs. Files count by what they hold: copies in other folders and on other machines are the "
     "same file. Comments, the names of pictures, search paths, threads and the order of buckets do not count, "
     "the version of the program does. Nothing is merged. Render the part again from the scene of the others."},
    {"FILM-SHARD-",
     "A part of a frame (`kinora render --samples`) cannot be written, read or added: it is not a part, is broken, "
     "belongs "
     "to another scene, seed, frame or version, or holds samples that another part has too. Nothing is merged."},
    {"FILM-", "The film refused sizes or channels that cannot be summed; the message says which."},
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
  return all;
}

}  // namespace kinora::app
