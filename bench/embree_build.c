// How long Embree takes to build a scene's structure when called directly, to hold étendue's build against: see embree_build.py.
//
//     embree_build FILE VERTEX_OFFSET VERTICES INDEX_OFFSET TRIANGLES THREADS
//
// FILE holds f32 positions and u32 indices as a glTF buffer does. Prints seconds from the device to the committed scene.
#include <embree4/rtcore.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

// The padding is for Embree, which reads 16 bytes at each position.
static void *slice(FILE *file, long offset, size_t bytes) {
    char *data = malloc(bytes + 16);
    if (!data || fseek(file, offset, SEEK_SET) || fread(data, 1, bytes, file) != bytes) {
        fprintf(stderr, "cannot read %zu bytes at %ld\n", bytes, offset);
        exit(1);
    }
    return data;
}

int main(int count, char **arguments) {
    if (count != 7) {
        fprintf(stderr, "usage: embree_build FILE VERTEX_OFFSET VERTICES INDEX_OFFSET TRIANGLES THREADS\n");
        return 2;
    }
    FILE *file = fopen(arguments[1], "rb");
    if (!file) {
        perror(arguments[1]);
        return 1;
    }
    size_t vertices = strtoull(arguments[3], NULL, 10), triangles = strtoull(arguments[5], NULL, 10);
    void *positions = slice(file, atol(arguments[2]), 12 * vertices);
    void *indices = slice(file, atol(arguments[4]), 12 * triangles);
    char config[32];
    snprintf(config, sizeof config, "threads=%d", atoi(arguments[6]));
    double start = now();
    RTCDevice device = rtcNewDevice(config);
    RTCScene scene = rtcNewScene(device);
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions, 0, 12, vertices);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices, 0, 12, triangles);
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(scene, mesh);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    rtcCommitScene(scene);
    printf("%.6f\n", now() - start);
    return rtcGetDeviceError(device) != RTC_ERROR_NONE;
}
