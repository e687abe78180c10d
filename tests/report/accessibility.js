// What tests ask of a page in a browser: a small part of the rules that axe has, as many as hold for what is there.
"use strict";

// Names, roles, values, sizes and landmarks: what is wrong, in words.
const rules = () => {
    const faults = [], name = (one) => {
        const by = one.getAttribute("aria-labelledby");
        const label = one.labels?.length ? Array.from(one.labels, (l) => l.textContent).join(" ") : "";
        const own = ["BUTTON", "A", "LEGEND"].includes(one.tagName) ? one.textContent : "";
        return (one.getAttribute("aria-label") || (by && document.getElementById(by)?.textContent) || label || own || "").trim();
    };
    for (const one of document.querySelectorAll("button, a, input, select, svg, [role], section, form"))
        if (!["status"].includes(one.getAttribute("role")) && !name(one)) faults.push(`no name: ${one.outerHTML.slice(0, 80)}`);
    const ids = Array.from(document.querySelectorAll("[id]"), (one) => one.id);
    if (new Set(ids).size !== ids.length) faults.push("an id twice");
    for (const one of document.querySelectorAll("[aria-describedby], [aria-labelledby], [for]"))
        for (const key of ["aria-describedby", "aria-labelledby", "for"])
            if (one.hasAttribute(key) && !document.getElementById(one.getAttribute(key))) faults.push(`${key} leads nowhere`);
    for (const one of document.querySelectorAll("[role=slider], [role=meter]")) {
        const [low, now, high] = ["valuemin", "valuenow", "valuemax"].map((key) => Number(one.getAttribute(`aria-${key}`)));
        if (!(low <= now && now <= high) || !one.getAttribute("aria-valuetext")) faults.push(`values of ${name(one)}`);
    }
    for (const one of document.querySelectorAll("[aria-hidden=true] *")) if (one.tabIndex >= 0 && one.hasAttribute("tabindex")) faults.push("hidden focus");
    for (const one of document.querySelectorAll("button, select, input[type=range]")) {
        const box = one.getBoundingClientRect();
        if (box.width && (box.height < 24 || box.width < 24)) faults.push(`small: ${one.id}`);
    }
    if (document.documentElement.lang !== "en" || !document.title) faults.push("language or title");
    if (document.querySelectorAll("h1").length !== 1 || !document.querySelector("main")) faults.push("landmarks");
    return faults;
};

// Each text on the page against what lies behind it, as WCAG has it; pictures and text in pictures apart.
const contrasts = () => {
    const parts = (text) => text.match(/[\d.]+/g).map(Number);
    const level = (rgb) => rgb.slice(0, 3).map((one) => one / 255)
        .map((one) => one <= 0.04045 ? one / 12.92 : ((one + 0.055) / 1.055) ** 2.4)
        .reduce((sum, one, i) => sum + one * [0.2126, 0.7152, 0.0722][i], 0);
    const low = [];
    for (const one of document.querySelectorAll("body *:not(script):not(style)")) {
        if (one.closest("svg") || !one.checkVisibility() || !Array.from(one.childNodes).some((n) => n.nodeType === 3 && n.data.trim())) continue;
        let ground = one;
        while (ground && (parts(getComputedStyle(ground).backgroundColor)[3] ?? 1) === 0) ground = ground.parentElement;
        const a = level(parts(getComputedStyle(one).color)), b = level(parts(getComputedStyle(ground ?? document.body).backgroundColor));
        const found = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
        if (found < 4.5) low.push(`${one.tagName} ${one.id} ${one.textContent.slice(0, 30)}: ${found.toFixed(2)}`);
    }
    return low;
};
