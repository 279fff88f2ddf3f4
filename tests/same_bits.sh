#!/usr/bin/env bash
# Shows whether two builds of lodestar render the same pictures, to the bit.
#
#   tests/same_bits.sh BEFORE AFTER           renders with both and compares
#   tests/same_bits.sh BINARY                 prints a line NAME HASH for every configuration, to be kept in a file
#   tests/same_bits.sh --against FILE BINARY  compares with the lines kept in FILE
#   tests/same_bits.sh --self-test BINARY     shows that a change of seed, a refused option and a lost line are caught
#   tests/same_bits.sh --list                 prints the configurations
#
# --only REGEX, put first, takes the configurations whose whole name matches.
#
# There are 41 configurations, small pictures of the repository's own scenes: every sampler and learner (tests/samplers.table), emitter sampling on and off, patterns, executions, steps, weights, grids, filters, parts that are merged,
# a render that is interrupted and resumed, PNG files and radiance maps.
#
# A hash covers every layer of a picture: names, types and values of its channels, and the window that it covers. It
# leaves out what else a file's header says (versions, settings, timings) and how the file is compressed.
# Hashes hold for one device and driver. Both binaries must run on the same, which LODESTAR_DEVICE can choose.
#
# A configuration that a binary does not render is an error: its message is printed. So an option that was renamed or
# deleted shows up as one that AFTER refuses. The exit status is 0 if all configurations give the same bits, 1 if one
# differs or fails, 2 if the command line is wrong.
#
# It needs bash and python3 with nothing but its standard library. Both binaries together take about two minutes on two
# cores once the driver has cached the kernels.
set -euo pipefail
export LC_ALL=C

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
scenes=$root/scenes

# Name, scene and options of every configuration: the rows of tests/samplers.table that have a picture, and those below. What stands
# in place of a scene with a colon in front of it is a function below: it takes more than one command.
configurations() {
  awk -F' *[|] *' '!/^#/ && $4 != "" { scene = $4; sub(/ .*/, "", scene); print $1 " | " scene " | " $2 substr($4, length(scene) + 1) }' \
    "$root/tests/samplers.table"
  cat <<'END'
product-no-nee          | cornell-box      | --nee off
bsdf-no-nee             | furnace          | --sampler bsdf --nee off
quadtree-no-nee         | cornell-box-hard | --sampler quadtree --nee off --spp 24
independent             | cornell-box      | --pattern independent
blue-noise              | cornell-box      | --pattern blue-noise
megakernel-slices       | cornell-box      | --execution megakernel --slice-ms 1 --samples-per-dispatch 2
wavefront               | cornell-box      | --execution wavefront
wavefront-bsdf          | lights           | --execution wavefront --sampler bsdf -D light=envmap
wavefront-mix-no-nee    | cornell-box      | --execution wavefront --sampler rejection-mix --nee off
steps-even              | cornell-box      | --steps even --spp-per-step 4
weights-growing         | cornell-box      | --sampler rejection-mix --steps growing --sample-weights growing
weights-even            | cornell-box      | --sample-weights even --decay 1
fallback                | door-ajar        | --fallback 4
noise                   | cornell-box      | --noise 0.1 --spp 48
roulette-throughput     | cornell-box      | --roulette throughput --rr-depth 3
roulette-contribution   | materials        | --roulette contribution --max-depth 8 --seed 7
table-sizes             | cornell-box      | --grid 4 --fallback 0 --directions 32 --normals 32
guide-set-authors       | materials        | --guide-set authors --sampler rejection-mix --rfilter gaussian
holes                   | holes            | --seed 5
holes-wavefront         | holes            | --execution wavefront --sampler bsdf --max-depth 9
crop-filter             | lights           | -D light=textured --crop 5,3,20,15 --rfilter tent
merge                   | :merge           | --sampler product
resume                  | :resume          | --sampler product
png                     | :png             | --sampler product
radiance                | :radiance        | --sampler product
END
}

# A scene with every kind of surface that --guide-set tells apart.
write_materials() { # FILE
  cat >"$1" <<'END'
<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="16" /></integrator>
  <sensor type="perspective">
    <float name="fov" value="45" />
    <transform name="to_world"><lookat origin="0, 3, 8" target="0, 0.6, 0" up="0, 1, 0" /></transform>
    <film type="hdrfilm"><rfilter type="box" /></film>
  </sensor>
  <shape type="rectangle">
    <transform name="to_world"><rotate x="1" angle="-90" /><scale value="6" /></transform>
    <bsdf type="roughplastic"><float name="alpha" value="0.2" /></bsdf>
  </shape>
  <shape type="sphere">
    <point name="center" x="-2.4" y="0.8" z="0" /><float name="radius" value="0.75" />
    <bsdf type="roughconductor"><float name="alpha" value="0.3" /></bsdf>
  </shape>
  <shape type="sphere">
    <point name="center" x="-0.8" y="0.8" z="0" /><float name="radius" value="0.75" />
    <bsdf type="roughdielectric"><float name="alpha" value="0.2" /></bsdf>
  </shape>
  <shape type="sphere">
    <point name="center" x="0.8" y="0.8" z="0" /><float name="radius" value="0.75" />
    <bsdf type="principled"><float name="roughness" value="0.4" /><float name="metallic" value="0.3" /></bsdf>
  </shape>
  <shape type="sphere">
    <point name="center" x="2.4" y="0.8" z="0" /><float name="radius" value="0.75" />
    <bsdf type="dielectric" />
  </shape>
  <shape type="rectangle">
    <transform name="to_world">
      <rotate x="1" angle="90" /><scale value="1.5" /><translate x="0" y="5" z="1" />
    </transform>
    <bsdf type="diffuse" />
    <emitter type="area"><rgb name="radiance" value="12, 11, 9" /></emitter>
  </shape>
</scene>
END
}

# The scene below a roof of thin glass and leaves with holes.
write_holes() { # FILE HOLES
  sed '/<\/scene>/d' "$1" >"$2"
  cat >>"$2" <<'END'
  <shape type="rectangle">
    <transform name="to_world"><rotate x="1" angle="90" /><scale value="3" /><translate x="-1" y="3" /></transform>
    <bsdf type="mask">
      <texture type="checkerboard" name="opacity"><rgb name="color0" value="0.1" /><rgb name="color1" value="0.8" /></texture>
      <bsdf type="twosided"><bsdf type="diffuse" /></bsdf>
    </bsdf>
  </shape>
  <shape type="rectangle">
    <transform name="to_world"><rotate x="1" angle="90" /><scale value="2" /><translate x="1" y="3.5" /></transform>
    <bsdf type="thindielectric" />
  </shape>
</scene>
END
}

scene_file() { # NAME
  if [[ $1 == materials || $1 == holes ]]; then echo "$work/$1.xml"; else echo "$scenes/$1/scene.xml"; fi
}

size=(--width 32 --height 24)

# Renders a scene into FOLDER with 16 samples per pixel, unless the options say how many.
render() { # BINARY FOLDER SCENE FILE OPTION...
  local binary=$1 folder=$2 scene=$3 file=$4
  shift 4
  local length=(--spp 16)
  if [[ " $* " == *" --spp "* ]]; then length=(); fi
  "$binary" render "$(scene_file "$scene")" "${size[@]}" "${length[@]}" "$@" --quiet -o "$folder/$file"
}

# Two parts with different samples, and what they are merged to.
merge() { # BINARY FOLDER OPTION...
  local binary=$1 folder=$2
  shift 2
  render "$binary" "$folder" cornell-box first.exr --sample-offset 0 --spp 8 "$@" &&
    render "$binary" "$folder" cornell-box second.exr --sample-offset 8 --spp 16 "$@" &&
    "$binary" merge -o "$folder/both.exr" "$folder/first.exr" "$folder/second.exr"
}

# A render in two halves, the second from the checkpoint of the first.
resume() { # BINARY FOLDER OPTION...
  local binary=$1 folder=$2
  shift 2
  render "$binary" "$folder" cornell-box first.exr --spp 8 --checkpoint "$folder/half" "$@" &&
    "$binary" resume "$folder/half" --spp 20 --quiet -o "$folder/whole.exr"
}

# Both tone curves.
png() { # BINARY FOLDER OPTION...
  local binary=$1 folder=$2
  shift 2
  render "$binary" "$folder" cornell-box srgb.png --tone srgb --exposure 0.5 "$@" &&
    render "$binary" "$folder" cornell-box paper.png --tone paper "$@"
}

# A map of what a guide has learned, the truth of it, and the first in false colors.
radiance() { # BINARY FOLDER OPTION...
  local binary=$1 folder=$2 scene
  shift 2
  scene=$(scene_file cornell-box)
  "$binary" radiance "$scene" "${size[@]}" --pixel 10,10 --spp 16 "$@" -o "$folder/map.exr" -o "$folder/map.png" &&
    "$binary" radiance "$scene" "${size[@]}" --pixel 10,10 --spp 4 --truth --directions 32 --map cylindrical -o "$folder/truth.exr"
}

# Writes a line FILE:CHANNEL HASH for every channel of every picture in FOLDER.
hash_channels() { # FOLDER
  python3 -c "$reader" "$1"
}

reader=$(cat <<'END'
import hashlib, os, struct, sys, zlib

TYPES = {0: (4, "uint"), 1: (2, "half"), 2: (4, "float")}
LINES_PER_CHUNK = {0: 1, 2: 1, 3: 16}


def text(data, at):
    end = data.index(0, at)
    return data[at:end].decode(), end + 1


def exr_attributes(data):
    at, attributes = 8, {}
    while data[at]:
        name, at = text(data, at)
        _, at = text(data, at)
        size = struct.unpack_from("<I", data, at)[0]
        attributes[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    return attributes, at + 1


def exr_channels(value):
    at, channels = 0, []
    while value[at]:
        name, at = text(value, at)
        channels.append((name, *TYPES[struct.unpack_from("<I", value, at)[0]]))
        at += 16
    return channels


def unpacked(data, size):
    """Undoes EXR's ZIP compression. A chunk that it would not make smaller is stored as it is."""
    if len(data) == size:
        return data
    data = bytearray(zlib.decompress(data))
    for i in range(1, len(data)):
        data[i] = (data[i - 1] + data[i] - 128) & 255
    half, whole = (len(data) + 1) // 2, bytearray(len(data))
    whole[0::2], whole[1::2] = data[:half], data[half:]
    return bytes(whole)


def exr_hashes(data):
    magic, version = struct.unpack_from("<II", data)
    if magic != 20000630 or version & 0x1A00:
        raise ValueError("not an EXR file of one part with scan lines")
    attributes, at = exr_attributes(data)
    channels = exr_channels(attributes["channels"])
    window = struct.unpack("<4i", attributes["dataWindow"])
    width, height = window[2] - window[0] + 1, window[3] - window[1] + 1
    compression = attributes["compression"][0]
    lines_per_chunk = LINES_PER_CHUNK[compression]
    line_size = width * sum(size for _, size, _ in channels)
    count = -(-height // lines_per_chunk)
    chunks = {}
    for offset in struct.unpack_from(f"<{count}Q", data, at):
        y, size = struct.unpack_from("<iI", data, offset)
        lines = min(lines_per_chunk, window[3] - y + 1)
        chunk = data[offset + 8 : offset + 8 + size]
        chunks[y] = unpacked(chunk, lines * line_size) if compression else chunk
    pixels = b"".join(chunks[y] for y in sorted(chunks))
    if len(pixels) != height * line_size:
        raise ValueError("lines are missing")
    start = 0
    for name, size, kind in channels:
        bits = hashlib.sha256(f"{kind} {window}".encode())
        for line in range(height):
            first = line * line_size + start
            bits.update(pixels[first : first + size * width])
        start += size * width
        yield name, bits

def png_hashes(data):
    at, stream, header = 8, b"", b""
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8 : at + 8 + size]
        if kind == b"IDAT":
            stream += body
        elif kind[0] & 32 == 0:
            header += kind + body
        at += 12 + size
    yield "pixels", hashlib.sha256(header + zlib.decompress(stream))


readers = {".exr": exr_hashes, ".png": png_hashes}
files = sorted(name for name in os.listdir(sys.argv[1]) if os.path.splitext(name)[1] in readers)
if not files:
    sys.exit("no picture was written")
for name in files:
    with open(os.path.join(sys.argv[1], name), "rb") as file:
        data = file.read()
    for channel, bits in readers[os.path.splitext(name)[1]](data):
        print(f"{name}:{channel} {bits.hexdigest()}")
END
)

# Runs one configuration and leaves in FOLDER: `channels` with a hash of each, and `log` with what was printed.
run_configuration() { # BINARY FOLDER SCENE OPTION...
  local binary=$1 folder=$2 scene=$3
  shift 3
  mkdir -p "$folder"
  {
    case $scene in
      :*) "${scene#:}" "$binary" "$folder" "$@" ;;
      *) render "$binary" "$folder" "$scene" picture.exr "$@" ;;
    esac &&
      hash_channels "$folder" >"$folder/channels.part" &&
      mv "$folder/channels.part" "$folder/channels" || true
  } >"$folder/log" 2>&1 </dev/null
}

# Prints a configuration's hash, or `failed`.
hash_of() { # FOLDER
  if [[ -f $1/channels ]]; then
    python3 -c 'import hashlib, sys; print(hashlib.sha256(sys.stdin.buffer.read()).hexdigest()[:32])' <"$1/channels"
  else
    echo failed
  fi
}

# Prints why a configuration failed: the first line with an error, else the last line.
reason() { # FOLDER
  awk '/[Ee]rror/ && !found { found = 1; line = $0 } !found { line = $0 } END { print line == "" ? "no message" : line }' \
    "$1/log"
}

# Prints the channels that are not the same in both folders.
different_channels() { # FOLDER FOLDER
  sort "$1/channels" "$2/channels" | uniq -u | cut -d' ' -f1 | sort -u | tr '\n' ' '
}

selected() {
  configurations | awk -F'|' -v only="^(${only:-.*})\$" '{ name = $1; gsub(/ /, "", name) } name ~ only'
}

# Calls FUNCTION with name, scene and options of every selected configuration.
each_configuration() { # FUNCTION ARGUMENT...
  local name scene options
  while IFS='|' read -r name scene options <&3; do
    # Unquoted: words are split at spaces.
    # shellcheck disable=SC2086
    "$@" ${name} ${scene} ${options}
  done 3< <(selected)
}

checked=0 faults=0
fault() { # LINE...
  faults=$((faults + 1))
  printf '%s\n' "$@"
}

# Compares NAME's two hashes, of which `failed` is one.
judge() { # NAME HASH HASH LABEL LABEL FOLDER FOLDER
  local name=$1 before=$2 after=$3 before_label=$4 after_label=$5 before_folder=$6 after_folder=$7 which=
  checked=$((checked + 1))
  if [[ $before == failed && $after == failed ]]; then
    fault "$name: NEITHER RENDERS: $(reason "$after_folder")"
  elif [[ $before == failed ]]; then
    if [[ -n $before_folder ]]; then which=": $(reason "$before_folder")"; fi
    fault "$name: $before_label REFUSES what $after_label accepts$which"
  elif [[ $after == failed ]]; then
    fault "$name: $after_label REFUSES what $before_label accepts: $(reason "$after_folder")"
  elif [[ $before != "$after" ]]; then
    if [[ -n $before_folder ]]; then which=" in $(different_channels "$before_folder" "$after_folder")"; fi
    fault "$name: DIFFERENT$which"
  fi
}

compare_one() { # BEFORE AFTER NAME SCENE OPTION...
  local before=$1 after=$2 name=$3 scene=$4
  shift 4
  run_configuration "$before" "$work/before/$name" "$scene" "$@"
  if [[ $name == "${seed_fault:-}" ]]; then set -- "$@" --seed 1; fi
  if [[ $name == "${option_fault:-}" ]]; then set -- "$@" --no-such-option; fi
  run_configuration "$after" "$work/after/$name" "$scene" "$@"
  judge "$name" "$(hash_of "$work/before/$name")" "$(hash_of "$work/after/$name")" BEFORE AFTER \
    "$work/before/$name" "$work/after/$name"
}

print_one() { # BINARY NAME SCENE OPTION...
  local binary=$1 name=$2 scene=$3 hash
  shift 3
  run_configuration "$binary" "$work/before/$name" "$scene" "$@"
  hash=$(hash_of "$work/before/$name")
  echo "$name $hash"
  if [[ $hash == failed ]]; then
    faults=$((faults + 1))
    echo "$name: $(reason "$work/before/$name")" >&2
  fi
}

compare_stored_one() { # FILE BINARY NAME SCENE OPTION...
  local file=$1 binary=$2 name=$3 scene=$4 stored
  shift 4
  stored=$(awk -v name="$name" '$1 == name { print $2 }' "$file")
  if [[ -z $stored ]]; then
    checked=$((checked + 1))
    fault "$name: $file has no hash of it"
    return
  fi
  run_configuration "$binary" "$work/after/$name" "$scene" "$@"
  judge "$name" "$stored" "$(hash_of "$work/after/$name")" "$file" "$binary" "" "$work/after/$name"
}

# Names in FILE that are no configurations (any more).
report_strangers() { # FILE
  local name
  while read -r name; do
    fault "$name: $1 has a hash of it, but there is no such configuration"
  done < <(awk 'NR == FNR { known[$1] = 1; next } NF && $1 !~ /^#/ && !($1 in known) { print $1 }' \
    <(configurations) "$1")
}

summarize() {
  if ((checked == 0)); then fault "no configuration was rendered"; fi
  if ((faults == 0)); then echo "$checked configurations: the same bits"; else echo "$checked configurations: $faults faults"; fi
  ((faults == 0))
}

expect() { # WHAT PATTERN OUTPUT
  if grep -Eq "$2" <<<"$3"; then echo "caught: $1"; else
    echo "NOT CAUGHT: $1"
    printf '%s\n' "$3" | sed 's/^/  /'
    return 1
  fi
}

# Faults in the last two of three configurations must be reported, and nothing else; so must a stored file's.
self_test() { # BINARY
  local binary=$1 output lines status=0
  only='bsdf-no-nee|product|merge'
  lines=$(each_configuration print_one "$binary")
  output=$(seed_fault=merge option_fault=product && each_configuration compare_one "$binary" "$binary" && summarize) || true
  expect "another seed" '^merge: DIFFERENT in .*both.exr:R .*both.exr:variance.R ' "$output" || status=1
  expect "a refused option" '^product: AFTER REFUSES what BEFORE accepts: .*no-such-option' "$output" || status=1
  expect "nothing else" '^3 configurations: 2 faults$' "$output" || status=1
  { grep -v '^merge ' <<<"$lines" | sed '/^product /s/.$/x/' && echo "stranger 0"; } >"$work/lines"
  output=$(each_configuration compare_stored_one "$work/lines" "$binary" && report_strangers "$work/lines" && summarize) ||
    true
  expect "another stored hash" '^product: DIFFERENT' "$output" || status=1
  expect "a lost line" '^merge: .* has no hash of it' "$output" || status=1
  expect "a line too many" '^stranger: .* no such configuration' "$output" || status=1
  expect "nothing else" '^3 configurations: 3 faults$' "$output" || status=1
  return $status
}

fail_usage() { # MESSAGE
  echo "same_bits.sh: $1" >&2
  sed -n '3,9p' "${BASH_SOURCE[0]}" | sed 's/^# *//' >&2
  exit 2
}

program() { # BINARY
  [[ -f $1 && -x $1 ]] || fail_usage "$1 is not a program"
  echo "$(cd "$(dirname "$1")" && pwd)/$(basename "$1")"
}

only=
if [[ ${1:-} == --only ]]; then
  [[ $# -ge 2 ]] || fail_usage "--only needs a regular expression"
  only=$2
  shift 2
fi
case ${1:-} in
  --list) selected && exit ;;
  --against) [[ $# -eq 3 && -r $2 ]] || fail_usage "--against needs a readable file and a binary" ;;
  --self-test) [[ $# -eq 2 ]] || fail_usage "--self-test needs a binary" ;;
  -*) fail_usage "there is no option $1" ;;
  *) [[ $# -eq 1 || $# -eq 2 ]] || fail_usage "give one binary or two" ;;
esac
command -v python3 >/dev/null || fail_usage "python3 is missing"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
write_materials "$work/materials.xml"
write_holes "$work/materials.xml" "$work/holes.xml"
case $1 in
  --against)
    binary=$(program "$3")
    each_configuration compare_stored_one "$2" "$binary"
    report_strangers "$2"
    summarize
    ;;
  --self-test)
    binary=$(program "$2")
    self_test "$binary"
    ;;
  *)
    before=$(program "$1")
    if [[ $# -eq 1 ]]; then
      each_configuration print_one "$before"
      ((faults == 0))
    else
      after=$(program "$2")
      each_configuration compare_one "$before" "$after"
      summarize
    fi
    ;;
esac
