/** Three numbers: an array, or anything that yields them, such as three.js' Vector3. Metres, in the mesh's space. */
export type Vector = Iterable<number>;

/** What became of a hit. Only "marked" leaves a dent. */
export type HitStatus = "marked" | "below yield" | "nothing reaches" | "accumulated" | "rigid";

/** Loads crumple.wasm from beside this file, from an address, or from bytes. */
export function start(source?: URL | string | BufferSource): Promise<Crumple>;

export interface Crumple {
  /** Makes a set from the bytes of a `.crumple` file, which `crumple bake` writes. Throws an Error that says what is wrong. */
  load(file: ArrayBuffer | Uint8Array): ExampleSet;
}

export interface ExampleSet {
  readonly vertexCount: number;
  /** No vertex moves further, m. */
  readonly depthLimit: number;
  /** Three indices a triangle. */
  readonly indices: Uint32Array;
  /** Makes an undamaged body. */
  body(): Body;
  /** Frees the set. Its bodies stay usable. */
  free(): void;
}

/** What is known of a blow. An impulse, or the striker's mass and velocity, is needed. */
export interface Blow {
  /** Out of the body. */
  normal?: Vector;
  /** N s. */
  impulse?: Vector;
  /** s. Needed if no example of the set knows its blow. */
  duration?: number;
  /** kg. */
  strikerMass?: number;
  /** m/s, relative to the body, before the touch. */
  strikerVelocity?: Vector;
  /** m. */
  strikerRadius?: number;
  /** Where it touches. */
  strikerShape?: "unknown" | "ball" | "pole" | "corner" | "wall";
}

export interface Body {
  /** Three numbers a vertex, in the module's memory: read or copy them before the next call. `deform` fills them. */
  readonly positions: Float32Array;
  /** The same, of unit length; null if the mesh has none. */
  readonly normals: Float32Array | null;
  /** Dents by a displacement of the contact into the body, m. */
  hitDisplacement(point: Vector, displacement: Vector): HitStatus;
  /** Dents by a blow. */
  hit(point: Vector, blow: Blow): HitStatus;
  /** Writes what changed into positions and normals; the first time, all. Returns the ranges of vertices that changed. */
  deform(): { first: number; count: number }[];
  /** Scales the depth of every dent: 0 is as new, 1 repairs nothing. */
  repair(keep?: number): void;
  /** The damage as bytes, the same on every platform. */
  save(): Uint8Array;
  /** Replaces the damage by saved damage of the same set. */
  load(saved: Uint8Array): void;
  free(): void;
}
