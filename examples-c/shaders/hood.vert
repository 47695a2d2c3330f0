#version 450
// hood.vert.h is this file as SPIR-V, so that building the examples needs no shader compiler. It was made with:
//
//     glslangValidator -V hood.vert --target-env vulkan1.1 --vn hood_vert -o hood.vert.h

layout(push_constant) uniform Camera {
    mat4 projection;
    mat4 model_view; // a rotation and a translation
};

layout(location = 0) in vec3 position; // m, z up
layout(location = 1) in vec4 normal;   // w: 0 for the hood, 1 for the ground

layout(location = 0) out vec3 surface;
layout(location = 1) out vec4 facing;
layout(location = 2) flat out vec3 eye;

void main() {
    gl_Position = projection * (model_view * vec4(position, 1));
    surface = position;
    facing = normal;
    eye = -transpose(mat3(model_view)) * model_view[3].xyz;
}
