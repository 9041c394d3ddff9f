# Makes a scene of points, seen from +z, in which all of them fit:
#
#     awk -f fit.awk [-v aspect=1.778] points.txt > scene.txt
#
# A line is "x y z", "x y z element", or "x y z radius [red green blue]". Elements
# get their van der Waals radii (Bondi 1964) and usual colours. Points without a
# radius get one that keeps most of them apart, and colours by their height.

BEGIN {
    table = "H 1.2 220,220,220 C 1.7 144,144,144 N 1.55 48,80,248 O 1.52 255,13,13 " \
        "F 1.47 144,224,80 NA 2.27 171,92,242 MG 1.73 138,255,0 SI 2.1 240,200,160 " \
        "P 1.8 255,128,0 S 1.8 255,200,50 CL 1.75 31,240,31 K 2.75 143,64,212 " \
        "CA 2.31 61,255,0 FE 2.04 224,102,51 ZN 1.39 125,128,176 BR 1.85 166,41,41 " \
        "I 1.98 148,0,148"
    count = split(table, words)
    for (i = 1; i < count; i += 3) {
        radius[words[i]] = words[i + 1]
        gsub(",", " ", words[i + 2])
        colour[words[i]] = words[i + 2]
    }
    number = "^[-+]?([0-9]+[.]?[0-9]*|[.][0-9]+)([eE][-+]?[0-9]+)?$"
    if (!aspect) aspect = 1
}

{ gsub("\r", "") }

NF == 0 { next }

$1 !~ number || $2 !~ number || $3 !~ number || (NF > 4 && NF != 7) {
    print "fit.awk: line " NR ": expected x y z and an element, or x y z radius red green blue, " \
        "found \"" $0 "\"" | "cat >&2"
    failed = 1
    exit 1
}

{
    n++
    for (k = 1; k <= 3; k++) {
        place[n, k] = $k + 0
        if (n == 1 || $k + 0 < low[k]) low[k] = $k + 0
        if (n == 1 || $k + 0 > high[k]) high[k] = $k + 0
    }
    if ($4 ~ number) {
        r[n] = $4
        c[n] = NF == 7 ? $5 " " $6 " " $7 : ""
    } else if (NF == 4) {
        element = toupper($4)
        r[n] = element in radius ? radius[element] : 2
        c[n] = element in colour ? colour[element] : "200 100 200"
    }
}

END {
    if (failed) exit 1
    for (k = 1; k <= 3; k++) {
        middle[k] = (low[k] + high[k]) / 2
        half += ((high[k] - low[k]) / 2) ^ 2
    }
    apart = sqrt(half) / (n + 1) ^ (1 / 3) / 3
    if (apart == 0) apart = 1
    # The radius about the middle in which everything is.
    for (i = 1; i <= n; i++) {
        if (r[i] == "") r[i] = apart
        distance = 0
        for (k = 1; k <= 3; k++) distance += (place[i, k] - middle[k]) ^ 2
        reach = sqrt(distance) + r[i]
        if (reach > size) size = reach
    }
    # From four times as far that is 1/sqrt(15) = 0.2582 to either side.
    printf "VP %.9g 0.52 1\nBG 255 255 255\nOBJ_N %d\n", 0.52 * aspect, n
    for (i = 1; i <= n; i++) {
        if (c[i] == "") {
            height = high[2] > low[2] ? (place[i, 2] - low[2]) / (high[2] - low[2]) : 0.5
            c[i] = sprintf("%d %d %d", 40 + 210 * height, 70 + 120 * height, 160 - 110 * height)
        }
        # The camera looks along its own +z.
        printf "S %.9g %.9g %.9g %.9g %s\n", place[i, 1] - middle[1], place[i, 2] - middle[2], \
            4 * size - (place[i, 3] - middle[3]), r[i], c[i]
    }
}
