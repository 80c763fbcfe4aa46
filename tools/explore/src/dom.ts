// SPDX-License-Identifier: MIT

type Attributes = Record<string, string | number | boolean | ((event: Event) => void)>;

const svgTags = new Set(["svg", "g", "circle", "rect", "path", "line", "text", "title"]);

/// make("button", {type: "button", onclick: go}, "Go"): an element with attributes, listeners, children.
export function make<E extends Element = HTMLElement>(tag: string, attributes: Attributes = {}, ...children: (Node | string)[]): E {
    const element = svgTags.has(tag)
        ? document.createElementNS("http://www.w3.org/2000/svg", tag)
        : document.createElement(tag);
    for (const [name, value] of Object.entries(attributes))
        if (typeof value === "function") element.addEventListener(name.slice(2), value);
        else if (typeof value === "boolean") element.toggleAttribute(name, value);
        else element.setAttribute(name, String(value));
    element.append(...children);
    return element as unknown as E;
}

export function find<E extends Element = HTMLElement>(selector: string): E {
    const element = document.querySelector<E>(selector);
    if (!element) throw new Error(`the page has no ${selector}`);
    return element;
}

export const percent = (share: number, digits = 1) => `${(100 * share).toFixed(digits)} %`;
