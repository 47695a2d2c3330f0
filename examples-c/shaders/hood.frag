#version 450
// Painted sheet metal on a ground with its shadow, under a row of lamps. Their reflections show every dent.
//
//     glslangValidator -V hood.frag --target-env vulkan1.1 --vn hood_frag -o hood.frag.h

layout(location = 0) in vec3 surface; // m, in the hood's space
layout(location = 1) in vec4 facing;
layout(location = 2) flat in vec3 eye;

layout(location = 0) out vec4 colour; // linear

const vec3 GROUND = vec3(0.75, 0.77, 0.79);
const vec3 PAINT = vec3(0.07, 0.22, 0.36);
const vec3 SUN = vec3(-0.52, 0.24, 0.82);
const float LAMPS = 2.2; // m above the hood

// The shadow of a box of half_size on the ground: the share of light blocked at an offset from its centre.
float shadow(vec2 at, vec2 half_size, float soft) {
    vec2 inside = smoothstep(-half_size - soft, -half_size + soft, at) * (1 - smoothstep(half_size - soft, half_size + soft, at));
    return inside.x * inside.y;
}

void main() {
    if (facing.w > 0.5) {
        float dark = 0.40 * shadow(surface.xy - vec2(0.07, 0.05), vec2(0.58, 0.43), 0.16) + 0.22 * shadow(surface.xy, vec2(0.58, 0.43), 0.05);
        colour = vec4(GROUND * (1 - dark), 1);
        return;
    }
    vec3 from_eye = normalize(surface - eye);
    vec3 n = normalize(facing.xyz);
    if (dot(n, from_eye) > 0) n = -n;

    vec3 r = reflect(from_eye, n);
    vec3 sky = mix(vec3(0.16, 0.18, 0.21), vec3(0.75, 0.80, 0.85), smoothstep(0.0, 0.9, r.z));
    float lamps = 0;
    if (r.z > 0.05) {
        vec2 at = surface.xy + r.xy / r.z * LAMPS;
        float beside = abs(fract(at.y / 0.62) - 0.5) * 0.62, edge = fwidth(at.y) + 0.05;
        lamps = (1 - smoothstep(0.10 - edge, 0.10 + edge, beside)) * (1 - smoothstep(2.6, 4.4, length(at)));
    }
    float diffuse = max(dot(n, SUN), 0);
    float fresnel = 0.04 + 0.96 * pow(1 - max(dot(n, -from_eye), 0), 5);
    colour = vec4(PAINT * (0.12 + 1.3 * pow(diffuse, 3)) + sky * (0.02 + fresnel) + lamps * (0.25 + 1.5 * fresnel), 1);
}
